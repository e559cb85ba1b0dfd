#include "analysis/verification.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/training.hpp"
#include "synthetic_run.hpp"

namespace gyrotherm {
namespace {

Dataset unseen_run() {
  SyntheticRun run;
  run.run_id = "synthetic-2";
  run.cycle_rates_c_per_min = {3.5};
  run.seed = 2;
  return make_synthetic_run(run);
}

class VerificationOfALinearModel : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    TrainingOptions options;
    options.inputs = "seven-point";
    options.method = "linear";
    const Dataset dataset = make_synthetic_run({});
    model_ = *train({dataset}, {*make_clusters(dataset)}, options);
  }
  static Verification verified(const Dataset& dataset) { return *verify(model_, dataset, *make_clusters(dataset)); }
  static inline Model model_;
};

TEST_F(VerificationOfALinearModel, IsOfARecordItHasNotSeen) {
  const Verification result = verified(unseen_run());
  EXPECT_FALSE(result.trained_on_this);
  EXPECT_LT(result.compensated.std, 0.3 * result.raw.std);
  EXPECT_GT(result.compensated.std, result.floor.deg_per_h * 0.7);
  EXPECT_NEAR(result.floor.deg_per_h, 0.002, 0.0008) << "0.02 °/h of one second";
}

TEST_F(VerificationOfALinearModel, SaysWhenItIsInSample) {
  const Verification result = verified(make_synthetic_run({}));
  EXPECT_TRUE(result.trained_on_this);
  EXPECT_TRUE(std::ranges::any_of(result.warnings, [](const std::string& w) { return w.find("in-sample") != w.npos; }));
  EXPECT_EQ(result.outside_trained_range, 0);
}

TEST_F(VerificationOfALinearModel, TellsRampsHoldsAndCornersApart) {
  const Dataset dataset = unseen_run();
  const Verification result = verified(dataset);
  EXPECT_EQ(result.ramps.count + result.holds.count, result.compensated.count);
  EXPECT_EQ(result.segments.size(), dataset.segments.size());
  EXPECT_DOUBLE_EQ(result.segments.front().duration_s, 1500);
  EXPECT_TRUE(result.segments.front().hold);
  EXPECT_GE(result.corners.count, 6 * 6) << "six corners, each over at least six clusters";
  EXPECT_LE(result.corners.count, 6 * 7);
}

TEST_F(VerificationOfALinearModel, CountsClustersOutsideTheTrainedRange) {
  Dataset dataset = unseen_run();
  dataset.temperature_c.block(0, 0, 300, 1).array() += 30;
  EXPECT_EQ(verified(dataset).outside_trained_range, 3);
}

TEST_F(VerificationOfALinearModel, WarnsOfAResidualBelowTheFloor) {
  const Dataset dataset = unseen_run();
  const Clusters clusters = *make_clusters(dataset);
  Clusters flattered = clusters;
  flattered.bias_deg_per_h = *predict(model_, clusters);
  const auto result = verify(model_, dataset, flattered);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->compensated.std, 0, 1e-12);
  EXPECT_TRUE(std::ranges::any_of(result->warnings, [](const std::string& w) { return w.find("over-fit") != w.npos; }));
}

TEST_F(VerificationOfALinearModel, WarnsOfMeansOverAnotherTime) {
  const Dataset dataset = unseen_run();
  const auto result = verify(model_, dataset, *make_clusters(dataset, 50));
  EXPECT_TRUE(
      std::ranges::any_of(result->warnings, [](const std::string& w) { return w.find("over 50 s") != w.npos; }));
}

}  // namespace
}  // namespace gyrotherm
