// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/verification.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analysis/model/training.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

data::Dataset unseen_run() {
  data::SyntheticRun run;
  run.run_id = "synthetic-2";
  run.cycle_rates_c_per_min = {3.5};
  run.seed = 2;
  return make_synthetic_run(run);
}

bool says(const Verification& result, const char* words) {
  return std::ranges::any_of(result.warnings, [&](const std::string& w) { return w.find(words) != w.npos; });
}

class VerificationOfALinearModel : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    TrainingOptions options;
    options.inputs = "seven-point";
    options.method = "linear";
    const data::Dataset dataset = data::make_synthetic_run({});
    model_ = *train({dataset}, {*make_clusters(dataset)}, options);
  }
  static Verification verified(const data::Dataset& dataset) {
    return *verify(model_, dataset, *make_clusters(dataset));
  }
  static inline Model model_;
};

TEST_F(VerificationOfALinearModel, IsOfARecordItHasNotSeen) {
  const Verification result = verified(unseen_run());
  EXPECT_FALSE(result.trained_on_this);
  EXPECT_LT(result.compensated.std, 0.3 * result.raw.std);
  EXPECT_GT(result.compensated.std, result.floor.deg_per_h * 0.7);
  EXPECT_NEAR(result.floor.deg_per_h, 0.002, 0.0008) << "0.02 °/h of one second";
}

/// The true bias is what the model predicts, less 0.01 °/h, and 0.003 °/h this way and that.
TEST_F(VerificationOfALinearModel, TellsItsErrorToTheTrueBias) {
  data::Dataset dataset = unseen_run();
  const data::Clusters clusters = *make_clusters(dataset);
  EXPECT_FALSE(verified(dataset).to_truth) << "of a real gyro nobody knows it";
  const Eigen::VectorXd predicted = clusters.bias_deg_per_h - verified(dataset).residual_deg_per_h;
  data::Clusters known = clusters;
  known.true_bias_deg_per_h = predicted.array() - 0.01;
  for (Eigen::Index k = 0; k < predicted.size(); ++k) known.true_bias_deg_per_h(k) += k % 2 == 0 ? 0.003 : -0.003;
  const auto to_truth = verify(model_, dataset, known)->to_truth;
  ASSERT_TRUE(to_truth);
  EXPECT_FALSE(to_truth->mean_removed);
  EXPECT_EQ(to_truth->figures.count, predicted.size());
  EXPECT_NEAR(to_truth->figures.mean, 0.01, 1e-4);
  EXPECT_NEAR(to_truth->figures.std, 0.003, 1e-4);
  EXPECT_NEAR(to_truth->figures.rmse, std::hypot(0.01, 0.003), 1e-4);
}

TEST_F(VerificationOfALinearModel, RemovesTheMeanOfTheErrorToTruthWhereTheZeroIsTheRecordsOwn) {
  data::Dataset dataset = unseen_run();
  dataset.bias_zero = "mean of the first hold removed";
  data::Clusters clusters = *make_clusters(dataset);
  clusters.true_bias_deg_per_h = clusters.bias_deg_per_h - verified(dataset).residual_deg_per_h;
  clusters.true_bias_deg_per_h.array() += 0.5;
  const auto to_truth = verify(model_, dataset, clusters)->to_truth;
  ASSERT_TRUE(to_truth);
  EXPECT_TRUE(to_truth->mean_removed);
  EXPECT_NEAR(to_truth->figures.rmse, 0, 1e-12);
}

TEST_F(VerificationOfALinearModel, SaysWhenItIsInSample) {
  const Verification result = verified(data::make_synthetic_run({}));
  EXPECT_TRUE(result.trained_on_this);
  EXPECT_TRUE(says(result, "in-sample"));
  EXPECT_EQ(result.outside.clusters, 0);
  EXPECT_EQ(result.outside.farthest_term, "");
}

TEST_F(VerificationOfALinearModel, TellsRampsHoldsAndCornersApart) {
  const data::Dataset dataset = unseen_run();
  const Verification result = verified(dataset);
  EXPECT_EQ(result.ramps.count + result.holds.count, result.compensated.count);
  EXPECT_EQ(result.segments.size(), dataset.segments.size());
  EXPECT_DOUBLE_EQ(result.segments.front().duration_s, 1500);
  EXPECT_TRUE(result.segments.front().hold);
  EXPECT_GE(result.corners.count, 6 * 6) << "six corners, each over at least six clusters";
  EXPECT_LE(result.corners.count, 6 * 7);
}

TEST_F(VerificationOfALinearModel, CountsClustersOutsideTheTrainedRange) {
  data::Dataset dataset = unseen_run();
  dataset.temperature_c.block(0, 0, 300, 1).array() += 30;
  const Verification result = verified(dataset);
  EXPECT_EQ(result.outside.clusters, 3);
  EXPECT_TRUE(result.outside.farthest_term.starts_with("A-")) << result.outside.farthest_term;
  EXPECT_GT(result.outside.farthest, 1) << "30 °C of a few";
  EXPECT_TRUE(says(result, "moved to its nearer end"));
}

TEST_F(VerificationOfALinearModel, DoesWithInputsOutsideWhatItIsTold) {
  data::Dataset dataset = unseen_run();
  dataset.temperature_c.block(0, 0, 300, 1).array() += 30;
  const data::Clusters clusters = *make_clusters(dataset);
  const auto with = [&](Outside outside) { return *verify(model_, dataset, clusters, outside); };
  const Verification clamped = with(Outside::clamp), refused = with(Outside::refuse);
  const Verification extrapolated = with(Outside::extrapolate);
  EXPECT_LT(clamped.compensated.max_abs, 0.5 * extrapolated.compensated.max_abs);
  EXPECT_EQ(refused.compensated.count, clamped.compensated.count - 3);
  EXPECT_EQ(refused.ramps.count + refused.holds.count, refused.compensated.count);
  EXPECT_LE(refused.compensated.max_abs, clamped.compensated.max_abs);
  EXPECT_TRUE(std::isnan(refused.residual_deg_per_h(0)));
  EXPECT_EQ(refused.raw.count, clamped.raw.count);
  EXPECT_TRUE(says(refused, "left out of the figures"));
  EXPECT_TRUE(says(extrapolated, "used there as it is"));
}

TEST_F(VerificationOfALinearModel, RefusesARecordWhollyOutside) {
  data::Dataset dataset = unseen_run();
  dataset.temperature_c.col(0).array() += 30;
  const auto result = verify(model_, dataset, *make_clusters(dataset), Outside::refuse);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, FaultKind::usage);
}

TEST_F(VerificationOfALinearModel, SaysHowWellItsFiguresAreKnown) {
  const Verification result = verified(unseen_run());
  for (const data::Figures* figures :
       {&result.raw, &result.compensated, &result.ramps, &result.holds, &result.corners}) {
    EXPECT_GE(figures->effective.of_std, 1);
    EXPECT_LE(figures->effective.of_std, figures->count);
    EXPECT_GT(std_error(*figures), 0);
  }
  EXPECT_LT(result.raw.effective.of_std, 0.2 * result.raw.count) << "the raw bias follows the temperature";
  EXPECT_GT(result.compensated.effective.of_std, result.raw.effective.of_std);
}

TEST_F(VerificationOfALinearModel, ExpectsInSampleWhatItsParametersLeave) {
  const Verification in_sample = verified(data::make_synthetic_run({}));
  EXPECT_EQ(in_sample.effective_parameters, 8);
  const double part = 1 - 8.0 / in_sample.compensated.count;
  EXPECT_DOUBLE_EQ(in_sample.expected_in_sample_std, in_sample.floor.deg_per_h * std::sqrt(part));
  EXPECT_TRUE(std::isnan(verified(unseen_run()).expected_in_sample_std));
}

TEST_F(VerificationOfALinearModel, SaysWhereTheZeroIsFittedToTheRecord) {
  constexpr const char* kWords = "the zero of the bias is fitted to this very record";
  data::Dataset dataset = unseen_run();
  EXPECT_FALSE(says(verified(dataset), kWords));
  dataset.bias_zero = "mean of the first hold removed";
  dataset.zero_is_its_own = true;
  EXPECT_TRUE(says(verified(dataset), kWords));
}

TEST_F(VerificationOfALinearModel, WarnsOfAResidualBelowTheFloor) {
  const data::Dataset dataset = unseen_run();
  const data::Clusters clusters = *make_clusters(dataset);
  data::Clusters flattered = clusters;
  flattered.bias_deg_per_h = *predict(model_, clusters);
  const auto result = verify(model_, dataset, flattered);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->compensated.std, 0, 1e-12);
  EXPECT_TRUE(says(*result, "over-fit"));
}

TEST_F(VerificationOfALinearModel, WarnsOfMeansOverAnotherTime) {
  const data::Dataset dataset = unseen_run();
  const auto result = verify(model_, dataset, *make_clusters(dataset, 50));
  EXPECT_TRUE(says(*result, "over 50 s"));
}

}  // namespace
}  // namespace gyrotherm::model
