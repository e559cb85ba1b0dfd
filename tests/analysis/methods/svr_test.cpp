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

/// Two folds of 2100 rows to train on, of a smooth function in noise.
std::vector<Fold> folds_of_many_rows() {
  std::vector<Fold> folds(2);
  for (Fold& fold : folds) {
    const bool second = &fold == &folds.back();
    const auto inputs = [&](Eigen::Index rows, std::uint64_t seed) {
      svm::SampleMatrix x(rows, 2);
      x << data::normal_vector(rows, seed), data::normal_vector(rows, seed + 1);
      return x;
    };
    const auto target = [](const svm::SampleMatrix& x, std::uint64_t seed) -> Eigen::VectorXd {
      return x.col(0).array().sin() + 0.2 * x.col(1).array() + 0.1 * data::normal_vector(x.rows(), seed).array();
    };
    fold.train_x = inputs(2100, second ? 10 : 20);
    fold.train_y = target(fold.train_x, 31);
    fold.test_x = inputs(200, second ? 40 : 50);
    fold.test_y = target(fold.test_x, 61);
    fold.target_scale = 1;
  }
  return folds;
}

TEST(ChooseSvr, AQuickSearchOfManyRowsIsThatOfEveryThirdOfThem) {
  std::vector<Fold> folds = folds_of_many_rows();
  MethodOptions options;
  options.tuning.swarm.particles = 3;
  options.tuning.swarm.iterations = 1;
  options.tuning.log2_c = {-2, 4};
  options.tuning.choice = svm::ChoiceRule::one_standard_error;
  options.quick = true;
  const auto quick = choose_svr(folds, options, {});
  for (Fold& fold : folds) {
    const auto every_third = Eigen::seq(0, Eigen::last, 3);
    fold.train_x = fold.train_x(every_third, Eigen::all).eval();
    fold.train_y = fold.train_y(every_third).eval();
  }
  options.quick = false;
  const auto thinned = choose_svr(folds, options, {});
  ASSERT_TRUE(quick && thinned);
  EXPECT_EQ(value_of(quick->parameters, "C"), value_of(thinned->parameters, "C") / 3);
  EXPECT_EQ(value_of(quick->parameters, "sigma"), value_of(thinned->parameters, "sigma"));
  EXPECT_EQ(value_of(quick->parameters, "epsilon"), value_of(thinned->parameters, "epsilon"));
  EXPECT_EQ(quick->tuning->one_standard_error->best.C, thinned->tuning->one_standard_error->best.C / 3);
  EXPECT_FALSE(quick->warnings.empty());
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
