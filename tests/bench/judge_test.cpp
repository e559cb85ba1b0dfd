// SPDX-License-Identifier: Apache-2.0
#include "bench/svr/judge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gyrotherm::bench {
namespace {

/// Two points at distance 1 with targets 1 and −1: β = ±(1 − ε)/(1 − k) as long as that is below C, b = 0.
struct TwoPoints {
  svm::SampleMatrix x = (svm::SampleMatrix(2, 1) << 0, 1).finished();
  Eigen::VectorXd y = (Eigen::VectorXd(2) << 1, -1).finished();
  PeerParameters parameters{.C = 10, .gamma = 0.5, .epsilon = 0.1};
  [[nodiscard]] Eigen::VectorXd beta(double factor = 1) const {
    const double size = factor * (1 - parameters.epsilon) / (1 - std::exp(-parameters.gamma));
    return (Eigen::VectorXd(2) << size, -size).finished();
  }
};

TEST(Judge, FindsNoGapAtAKnownOptimum) {
  const TwoPoints two;
  const Verdict verdict = assess_solution(two.x, two.y, two.parameters, two.beta(), 0);
  const double size = two.beta()[0];
  EXPECT_TRUE(verdict.feasible);
  EXPECT_EQ(verdict.support_vectors, 2);
  EXPECT_NEAR(verdict.dual, -size * (1 - two.parameters.epsilon), 1e-14);
  EXPECT_NEAR(verdict.gap, 0, 1e-14);
  EXPECT_NEAR(verdict.violation, 0, 1e-14);
}

TEST(Judge, FindsAGapAwayFromTheOptimum) {
  const TwoPoints two;
  for (const double factor : {0.5, 0.99, 1.01, 1.5})
    EXPECT_GT(assess_solution(two.x, two.y, two.parameters, two.beta(factor), 0).gap, 1e-5) << factor;
}

TEST(Judge, CallsWhatLeavesTheBoxOrTheBalanceInfeasible) {
  const TwoPoints two;
  EXPECT_FALSE(assess_solution(two.x, two.y, two.parameters, two.beta(100), 0).feasible);
  Eigen::VectorXd unbalanced = two.beta();
  unbalanced[0] += 1e-6;
  EXPECT_FALSE(assess_solution(two.x, two.y, two.parameters, unbalanced, 0).feasible);
}

TEST(Judge, BoundsTheSolversDistanceFromTheOptimumAsTheSolverDoes) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0, 1);
    svm::SampleMatrix x = svm::SampleMatrix::NullaryExpr(40, 3, [&] { return normal(generator); });
    const Eigen::VectorXd y = Eigen::VectorXd::NullaryExpr(40, [&] { return normal(generator); });
    const PeerParameters parameters{.C = std::exp2(8 * uniform(generator) - 2),
                                    .gamma = std::exp2(4 * uniform(generator) - 4),
                                    .epsilon = std::exp2(-1 - 5 * uniform(generator))};
    const auto loose = solve_svr(x, y, own_parameters(parameters), {.relative_gap = 1e-3});
    const auto tight = solve_svr(x, y, own_parameters(parameters), {.relative_gap = 1e-8});
    ASSERT_TRUE(loose && tight) << "seed " << seed;
    const Verdict first = assess_solution(x, y, parameters, loose->beta, loose->b);
    const Verdict second = assess_solution(x, y, parameters, tight->beta, tight->b);
    EXPECT_TRUE(first.feasible) << "seed " << seed;
    EXPECT_LE(first.dual - second.dual, first.gap * std::abs(first.dual) * (1 + 1e-9)) << "seed " << seed;
    EXPECT_NEAR(first.gap, loose->relative_gap, 1e-9) << "seed " << seed;
    EXPECT_LE(second.gap, 1.001e-8) << "seed " << seed;
  }
}

}  // namespace
}  // namespace gyrotherm::bench
