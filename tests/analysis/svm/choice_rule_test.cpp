// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/choice_rule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/svm/tuning.hpp"

namespace gyrotherm::svm {
namespace {

const std::vector<double> kFourths(4, 0.25);

/// Returns a position with the given mean squared errors on four equal folds.
EvaluatedPosition position_with_errors(std::vector<double> position, std::vector<double> fold_mse) {
  for (double& mse : fold_mse) mse /= 4;
  return {.position = std::move(position), .shares = std::move(fold_mse)};
}

TEST(HeldOutStandardError, EqualsDeviationOverRootOfCountForEqualFolds) {
  const EvaluatedPosition position = position_with_errors({0, 0, 0}, {1, 2, 4, 5});
  EXPECT_DOUBLE_EQ(mean_squared_error(position), 3);
  EXPECT_DOUBLE_EQ(standard_error(position, kFourths), std::sqrt((4 + 1 + 1 + 4) / 3.0) / 2);
}

TEST(HeldOutStandardError, IsZeroForEqualErrorsOrOneFold) {
  EXPECT_EQ(standard_error({.position = {}, .shares = {0.5}}, std::vector<double>{1}), 0);
  EXPECT_DOUBLE_EQ(standard_error({.position = {}, .shares = {1, 3}}, std::vector<double>{0.25, 0.75}), 0);
}

/// Compares the formula with the scatter over many draws of folds of different size.
TEST(HeldOutStandardError, MatchesSimulatedErrorOfMean) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const std::vector<double> parts{0.22, 0.24, 0.26, 0.28};
  constexpr int kDraws = 20000;
  double squares = 0, variances = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    EvaluatedPosition position{.position = {}, .shares = {}};
    for (const double part : parts) position.shares.push_back(part * (3 + normal(random)));
    squares += std::pow(mean_squared_error(position) - 3, 2);
    variances += std::pow(standard_error(position, parts), 2);
  }
  EXPECT_NEAR(variances / squares, 1, 0.05);
}

TEST(OneStandardErrorRule, SelectsSmallestCWithinOneStandardError) {
  // The lowest error is 3, with a standard error of 0.91.
  const std::vector<EvaluatedPosition> all{
      position_with_errors({8, 1, -5}, {1, 2, 4, 5}), position_with_errors({2, 1, -5}, {3.8, 3.8, 3.8, 3.8}),
      position_with_errors({0, 1, -5}, {4, 4, 4, 4}), position_with_errors({5, 1, -5}, {3.1, 3.1, 3.1, 3.1})};
  const OneStandardErrorChoice choice = simplest_within_one_standard_error(all, kFourths);
  EXPECT_EQ(choice.best, 0U);
  EXPECT_EQ(choice.simplest, 1U);
  EXPECT_EQ(choice.within, 3);
}

TEST(OneStandardErrorRule, PrefersWiderKernelThenWiderTubeWithinOctaveOfC) {
  const std::vector<double> same{1, 2, 4, 5};
  const std::vector<EvaluatedPosition> all{position_with_errors({2.9, 1.5, -5}, same),
                                           position_with_errors({2.1, 0.5, -2}, same),
                                           position_with_errors({2.6, 1.1, -3.5}, same)};
  EXPECT_EQ(simplest_within_one_standard_error(all, kFourths).simplest, 2U);
}

TEST(OneStandardErrorRule, SelectsBestWhenFoldsAgree) {
  const std::vector<EvaluatedPosition> all{position_with_errors({0, 0, 0}, {2, 2, 2, 2}),
                                           position_with_errors({9, 0, 0}, {1, 1, 1, 1})};
  EXPECT_EQ(simplest_within_one_standard_error(all, kFourths).simplest, 1U);
}

/// For random errors, the chosen position is within one standard error of the best, and no simpler position is. The
/// order in which threads add positions has no effect.
TEST(OneStandardErrorRule, SelectsSimplestPositionForAnyErrors) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(-2, 8), error(1, 3);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    std::vector<EvaluatedPosition> all;
    for (int k = 0; k < 40; ++k)
      all.push_back(position_with_errors({coordinate(random), coordinate(random), coordinate(random)},
                                         {error(random), error(random), error(random), error(random)}));
    const OneStandardErrorChoice choice = simplest_within_one_standard_error(all, kFourths);
    const double limit = mean_squared_error(all[choice.best]) + choice.standard_error;
    EXPECT_LE(mean_squared_error(all[choice.simplest]), limit);
    for (const EvaluatedPosition& other : all) {
      EXPECT_GE(mean_squared_error(other), mean_squared_error(all[choice.best]));
      if (mean_squared_error(other) <= limit) {
        EXPECT_FALSE(is_simpler(other, all[choice.simplest]));
      }
    }
    const EvaluatedPosition taken = all[choice.simplest];
    std::ranges::shuffle(all, random);
    EXPECT_EQ(all[simplest_within_one_standard_error(all, kFourths).simplest].position, taken.position);
  }
}

TEST(ChoiceRules, ParseKeywords) {
  EXPECT_EQ(parse_choice("best").value(), ChoiceRule::best);
  EXPECT_EQ(parse_choice("one-se").value(), ChoiceRule::one_standard_error);
  EXPECT_EQ(parse_choice("simplest").error().kind, FaultKind::usage);
}

/// Returns four folds of a noisy line. Its optimum is flat.
std::vector<TuningFold> noisy_folds() {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::vector<TuningFold> folds;
  for (int f = 0; f < 4; ++f) {
    const auto draw = [&](SampleMatrix& x, Eigen::VectorXd& y, Eigen::Index rows) {
      x = SampleMatrix::NullaryExpr(rows, 2, [&] { return normal(random); });
      y = 0.8 * x.col(0) + 0.5 * Eigen::VectorXd::NullaryExpr(rows, [&] { return normal(random); });
    };
    TuningFold fold;
    draw(fold.train_x, fold.train_y, 45);
    draw(fold.test_x, fold.test_y, 15);
    fold.target_scale = 1;
    folds.push_back(std::move(fold));
  }
  return folds;
}

TEST(OneStandardErrorTuning, KeepsPathOfSwarmAndSelectsSimplerPosition) {
  TuningOptions options;
  options.swarm.particles = 6;
  options.swarm.iterations = 5;
  const auto best = tune_svr(noisy_folds(), options);
  options.choice = ChoiceRule::one_standard_error;
  const auto simple = tune_svr(noisy_folds(), options);
  ASSERT_TRUE(best && simple);
  EXPECT_FALSE(best->one_standard_error);
  ASSERT_TRUE(simple->one_standard_error);
  EXPECT_EQ(simple->swarm.history, best->swarm.history) << "the rule does not change the swarm";
  EXPECT_EQ(simple->one_standard_error->best.C, best->best.C);
  EXPECT_EQ(simple->one_standard_error->best_mse, best->cross_validation_mse);
  EXPECT_LT(simple->best.C, best->best.C);
  EXPECT_GT(simple->cross_validation_mse, best->cross_validation_mse);
  EXPECT_LE(simple->cross_validation_mse, best->cross_validation_mse + simple->one_standard_error->standard_error_mse);
  EXPECT_NEAR(simple->cross_validation_mse, *cross_validation_error(noisy_folds(), simple->best, {}, 1e9), 1e-12);
}

TEST(OneStandardErrorTuning, DoesNotDependOnThreadCount) {
  TuningOptions options;
  options.swarm.particles = 6;
  options.swarm.iterations = 3;
  options.choice = ChoiceRule::one_standard_error;
  options.swarm.threads = 1;
  const auto one = tune_svr(noisy_folds(), options);
  options.swarm.threads = 2;
  const auto two = tune_svr(noisy_folds(), options);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->best.C, two->best.C);
  EXPECT_EQ(one->best.sigma, two->best.sigma);
  EXPECT_EQ(one->best.epsilon, two->best.epsilon);
  EXPECT_EQ(one->one_standard_error->within, two->one_standard_error->within);
}

}  // namespace
}  // namespace gyrotherm::svm
