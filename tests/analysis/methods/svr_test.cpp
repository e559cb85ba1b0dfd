// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/svr.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

data::Clusters clusters_with(const Eigen::VectorXd& start_s, const Eigen::VectorXd& bias) {
  data::Clusters clusters;
  clusters.start_s = start_s;
  clusters.bias_deg_per_h = bias;
  return clusters;
}

TEST(ForwardPrediction, LeavesAConstantAndTheFirstValuesAsTheyAre) {
  EXPECT_LT((forward_prediction(Eigen::VectorXd::Constant(50, 3.5)).array() - 3.5).abs().maxCoeff(), 1e-12);
  const Eigen::VectorXd values = data::normal_vector(50, 1);
  EXPECT_EQ(forward_prediction(values, {.order = 6, .step = 0.1}).head(6), values.head(6));
}

TEST(ForwardPrediction, FollowsTheFormulaByHand) {
  const Eigen::VectorXd values = (Eigen::VectorXd(4) << 1, 2, 4, 3).finished();
  const Eigen::VectorXd predicted = forward_prediction(values, {.order = 2, .step = 0.5});
  EXPECT_DOUBLE_EQ(predicted(2), 1.5);                    // a = (½, ½); e = 2.5, Σy² = 5
  const double a1 = 0.5 + 0.25 * 2, a2 = 0.5 + 0.25 * 1;  // µ e/Σy² = 0.25
  EXPECT_DOUBLE_EQ(predicted(3), a1 * 4 + a2 * 2);
}

TEST(ForwardPrediction, LearnsARecurrence) {
  Eigen::VectorXd wave(4000);
  for (Eigen::Index n = 0; n < wave.size(); ++n) wave(n) = std::sin(0.3 * static_cast<double>(n));
  const Eigen::VectorXd predicted = forward_prediction(wave, {.order = 2, .step = 0.5});
  EXPECT_LT((predicted - wave).tail(100).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ForwardPrediction, StaysBoundedWhateverTheSizeOfTheBias) {
  for (const double size : {1e-6, 1.0, 1e6}) {
    const Eigen::VectorXd values = size * data::normal_vector(2000, 3);
    EXPECT_LT(forward_prediction(values).cwiseAbs().maxCoeff(), 10 * size);
  }
}

TEST(ForwardPrediction, TakesNoiseFromABiasThatStandsStill) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Eigen::VectorXd noise = data::normal_vector(500, seed);
    const data::Clusters clusters = clusters_with(Eigen::VectorXd::LinSpaced(500, 0, 49900), noise.array() + 7);
    EXPECT_LT((filter_bias(clusters).array() - 7).square().mean(), 0.7 * noise.squaredNorm() / 500) << "seed " << seed;
  }
}

TEST(BiasFilter, BeginsAnewAfterAGapAndInAnotherRecord) {
  const Eigen::VectorXd bias = data::normal_vector(30, 2);
  Eigen::VectorXd start = Eigen::VectorXd::LinSpaced(30, 0, 2900);
  start.segment(10, 10).array() += 500;                     // a gap
  start.tail(10) = Eigen::VectorXd::LinSpaced(10, 0, 900);  // another record
  const Eigen::VectorXd filtered = filter_bias(clusters_with(start, bias));
  for (const Eigen::Index first : {0, 10, 20}) {
    const Eigen::VectorXd part = bias.segment(first, 10);
    const Eigen::VectorXd alone = filter_bias(clusters_with(Eigen::VectorXd::LinSpaced(10, 0, 900), part));
    EXPECT_EQ(filtered.segment(first, 10), alone) << first;
  }
}

}  // namespace
}  // namespace gyrotherm::methods
