#include "analysis/model/trained_range.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analysis/small_model.hpp"

namespace gyrotherm {
namespace {

/// The small model was trained on A − B in [−1, 1] and dA/dt in [−5, 5].
SampleMatrix two_outside() { return (SampleMatrix(4, 2) << 0.5, 1, 1.5, 1, 0, -7.5, -1, 5).finished(); }

TEST(TrainedRange, ClampMovesEachInputToTheNearerEnd) {
  const Model model = small_svr_model();
  const RangedInputs ranged = within_range(model, two_outside(), Outside::clamp);
  EXPECT_EQ(ranged.inputs, (SampleMatrix(4, 2) << 0.5, 1, 1, 1, 0, -5, -1, 5).finished());
  EXPECT_EQ(ranged.rows, (std::vector<Eigen::Index>{1, 2}));
}

TEST(TrainedRange, NamesTheFarthestTermAsAPartOfItsRange) {
  const RangedInputs ranged = within_range(small_svr_model(), two_outside(), Outside::extrapolate);
  EXPECT_EQ(ranged.worst_term, 0) << "0.5 of 2 is as far as 2.5 of 10; the first is named";
  EXPECT_DOUBLE_EQ(ranged.worst_excess, 0.25);
  EXPECT_EQ(ranged.inputs, two_outside());
}

TEST(TrainedRange, RefusesWholeRows) {
  const Model model = small_svr_model();
  const Eigen::VectorXd predicted = predict(model, two_outside(), Outside::refuse);
  EXPECT_TRUE(std::isfinite(predicted(0)));
  EXPECT_TRUE(std::isnan(predicted(1)));
  EXPECT_TRUE(std::isnan(predicted(2)));
  EXPECT_TRUE(std::isfinite(predicted(3)));
}

TEST(TrainedRange, PoliciesAgreeInside) {
  const Model model = small_svr_model();
  const SampleMatrix inside = (SampleMatrix(2, 2) << -1, 5, 0.25, -0.5).finished();
  for (const Outside policy : {Outside::clamp, Outside::refuse, Outside::extrapolate}) {
    EXPECT_EQ(predict(model, inside, policy), predict(model, inside)) << name(policy);
    EXPECT_EQ(within_range(model, inside, policy).worst_term, -1);
  }
}

TEST(TrainedRange, ClampGoesOnFromTheLastTrainedValueWithoutAStep) {
  const Model model = small_svr_model();
  const SampleMatrix edge = (SampleMatrix(1, 2) << 1, 2).finished();
  for (const double beyond : {1e-6, 0.1, 100.0}) {
    const SampleMatrix outside = (SampleMatrix(1, 2) << 1 + beyond, 2).finished();
    EXPECT_EQ(predict(model, outside, Outside::clamp), predict(model, edge)) << beyond;
  }
}

TEST(TrainedRange, TheRoundingOfAMeanIsNotOutside) {
  const SampleMatrix edge = (SampleMatrix(1, 2) << 1 + 1e-14, -5 - 1e-12).finished();
  EXPECT_TRUE(within_range(small_svr_model(), edge, Outside::refuse).rows.empty());
}

TEST(TrainedRange, AMissingInputIsNotOutside) {
  const SampleMatrix missing = (SampleMatrix(1, 2) << std::nan(""), 100).finished();
  const RangedInputs ranged = within_range(small_svr_model(), missing, Outside::clamp);
  EXPECT_TRUE(ranged.rows.empty());
  EXPECT_TRUE(std::isnan(predict(small_svr_model(), missing, Outside::clamp)(0)));
}

TEST(TrainedRange, PoliciesAreReadByName) {
  for (const Outside policy : {Outside::clamp, Outside::refuse, Outside::extrapolate}) {
    EXPECT_EQ(*parse_outside(name(policy)), policy);
  }
  const auto wrong = parse_outside("ignore");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().kind, FaultKind::usage);
}

}  // namespace
}  // namespace gyrotherm
