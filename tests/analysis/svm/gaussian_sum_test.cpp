// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/gaussian_sum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/analysis/svm/gaussian_formula.hpp"

namespace gyrotherm::svm {
namespace {

struct Problem {
  SampleMatrix centres, points;
  Eigen::VectorXd widths, weights;
};

SampleMatrix random_rows(Eigen::Index rows, Eigen::Index columns, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  return SampleMatrix::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

/// Returns centres and points in a random subspace of `rank` dimensions within the `inputs` dimensions.
Problem random_problem(Eigen::Index centres, Eigen::Index points, Eigen::Index inputs, Eigen::Index rank, double width,
                       std::mt19937_64& generator) {
  const SampleMatrix span = random_rows(rank, inputs, generator);
  Problem problem;
  problem.centres = random_rows(centres, rank, generator) * span;
  problem.points = random_rows(points, rank, generator) * span;
  problem.widths = Eigen::VectorXd::Constant(centres, width);
  problem.weights = 10 * random_rows(centres, 1, generator);
  return problem;
}

/// Returns the largest error relative to Σ|w| over the points and over all instruction sets of this processor.
double worst_error(const Problem& problem) {
  const GaussianSum sum(problem.centres, problem.widths, problem.weights);
  Eigen::VectorXd exact(problem.points.rows());
  for (Eigen::Index i = 0; i < exact.size(); ++i)
    exact(i) = gaussian_formula(problem.points, i, problem.centres, problem.widths, problem.weights);
  double worst = 0;
  for (const auto* loops : all_gaussian_loops()) {
    worst = std::max(worst, (sum.at(problem.points, *loops) - exact).cwiseAbs().maxCoeff());
  }
  return worst / problem.weights.lpNorm<1>();
}

TEST(GaussianSum, MatchesFormulaWithinBound) {
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 generator(seed);
    const auto any = [&](int from, int to) { return std::uniform_int_distribution<>(from, to)(generator); };
    const int inputs = any(1, 20);
    const double width = std::exp2(any(-3, 5));
    Problem problem = random_problem(any(1, 90), any(1, 110), inputs, any(1, inputs), width, generator);
    if (seed % 3 == 0) problem.widths = width * (0.2 + random_rows(problem.widths.size(), 1, generator).array().abs());
    if (seed % 5 == 0) problem.points += random_rows(problem.points.rows(), inputs, generator);
    if (seed % 7 == 0) problem.weights(0) = 0;
    EXPECT_LT(worst_error(problem), seed % 5 == 0 ? 1e-11 : 1e-12);
  }
}

TEST(GaussianSum, IsAccurateForSmoothModelWithManyVectors) {
  std::mt19937_64 generator(1);
  const Problem problem = random_problem(1000, 100, 13, 7, 8, generator);
  EXPECT_LT(worst_error(problem), 2e-15);
}

/// The weights are ±C and sum to zero, as in a support vector machine.
TEST(GaussianSum, IsAccurateWhenLargeWeightsCancel) {
  std::mt19937_64 generator(8);
  Problem problem = random_problem(1000, 100, 8, 8, 30, generator);
  for (Eigen::Index j = 0; j < 1000; ++j) problem.weights(j) = j % 2 == 0 ? 700 : -700;
  EXPECT_LT(worst_error(problem) * problem.weights.lpNorm<1>(), 1e-10);
}

TEST(GaussianSum, FindsDimensionsSpannedByCentres) {
  std::mt19937_64 generator(2);
  const Problem problem = random_problem(200, 1, 13, 7, 1, generator);
  EXPECT_EQ(GaussianSum(problem.centres, problem.widths, problem.weights).dimensions(), 7);
  const SampleMatrix same = SampleMatrix::Constant(5, 3, 0.3);
  const GaussianSum point(same, Eigen::VectorXd::Ones(5), Eigen::VectorXd::Ones(5));
  EXPECT_EQ(point.dimensions(), 0);
  EXPECT_DOUBLE_EQ(point.at(same)(2), 5);
}

TEST(GaussianSum, IsZeroFarAway) {
  std::mt19937_64 generator(3);
  Problem problem = random_problem(40, 4, 3, 2, 0.5, generator);
  problem.points.row(1).setConstant(1e4);
  problem.points.row(2).setConstant(-1e200);
  for (const auto* loops : all_gaussian_loops()) {
    const Eigen::VectorXd f = GaussianSum(problem.centres, problem.widths, problem.weights).at(problem.points, *loops);
    EXPECT_NEAR(f(1), 0, 1e-290);
    EXPECT_NEAR(f(2), 0, 1e-290);
  }
}

TEST(GaussianSum, IsNaNWhenPointIsNotFinite) {
  std::mt19937_64 generator(4);
  Problem problem = random_problem(40, 7, 3, 3, 2, generator);
  const GaussianSum sum(problem.centres, problem.widths, problem.weights);
  const Eigen::VectorXd before = sum.at(problem.points);
  problem.points(1, 2) = std::nan("");
  problem.points(4, 0) = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd after = sum.at(problem.points);
  for (const Eigen::Index i : {1, 4}) EXPECT_TRUE(std::isnan(after(i)));
  for (const Eigen::Index i : {0, 2, 3, 5, 6}) EXPECT_EQ(after(i), before(i));
}

TEST(GaussianSum, EvaluatesPointsIndependently) {
  std::mt19937_64 generator(5);
  Problem problem = random_problem(70, 100, 5, 4, 0.4, generator);
  // The first 50 points are near enough for the product form, the others are not.
  problem.points.topRows(50) *= 0.05;
  const GaussianSum sum(problem.centres, problem.widths, problem.weights);
  const Eigen::VectorXd all = sum.at(problem.points);
  for (Eigen::Index i = 0; i < all.size(); ++i) EXPECT_EQ(sum.at(problem.points.row(i))(0), all(i));
}

TEST(GaussianSum, IsZeroWithoutCentres) {
  const GaussianSum none(SampleMatrix(0, 3), Eigen::VectorXd(0), Eigen::VectorXd(0));
  EXPECT_EQ(none.at(SampleMatrix::Ones(2, 3)), Eigen::VectorXd::Zero(2));
  const GaussianSum weightless(SampleMatrix::Ones(2, 3), Eigen::VectorXd::Ones(2), Eigen::VectorXd::Zero(2));
  EXPECT_EQ(weightless.at(SampleMatrix::Ones(2, 3)), Eigen::VectorXd::Zero(2));
}

TEST(GaussianSum, AcceptsWeightsOfAnySize) {
  std::mt19937_64 generator(6);
  Problem problem = random_problem(30, 10, 3, 3, 1, generator);
  for (const double size : {1e-280, 1e280}) {
    Problem scaled = problem;
    scaled.weights *= size;
    EXPECT_LT(worst_error(scaled), 1e-13);
  }
}

/// Samples far from the origin. Some β are 0.
struct Trained {
  SampleMatrix x;
  Eigen::VectorXd beta;
};

Trained random_training(Eigen::Index samples, Eigen::Index inputs, double zero_share, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  std::bernoulli_distribution zero(zero_share);
  return {.x = SampleMatrix::NullaryExpr(samples, inputs, [&] { return 3 + normal(generator); }),
          .beta = Eigen::VectorXd::NullaryExpr(samples, [&] { return zero(generator) ? 0 : 10 * normal(generator); })};
}

/// Returns the largest error relative to Σ|β|, over all instruction sets of this processor.
double worst_error(const Trained& trained, double sigma) {
  Eigen::VectorXd exact(trained.beta.size());
  const Eigen::VectorXd widths = Eigen::VectorXd::Constant(exact.size(), sigma);
  for (Eigen::Index i = 0; i < exact.size(); ++i)
    exact(i) = gaussian_formula(trained.x, i, trained.x, widths, trained.beta);
  double worst = 0;
  for (const auto* loops : all_gaussian_loops())
    worst = std::max(worst, (gaussian_response(trained.x, sigma, trained.beta, *loops) - exact).cwiseAbs().maxCoeff());
  return worst / trained.beta.lpNorm<1>();
}

TEST(GaussianPairs, MatchFormulaWithinBound) {
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 generator(seed);
    const auto any = [&](int from, int to) { return std::uniform_int_distribution<>(from, to)(generator); };
    Trained trained = random_training(any(1, 300), any(1, 15), any(0, 9) / 10.0, generator);
    trained.beta(0) = 1;
    if (seed % 4 == 0) trained.x.bottomRows(trained.x.rows() / 2) = trained.x.topRows(trained.x.rows() / 2).eval();
    EXPECT_LT(worst_error(trained, std::exp2(any(-3, 5))), 1e-12);
  }
}

TEST(GaussianPairs, HandleGroupsOfAnySize) {
  std::mt19937_64 generator(1);
  for (const Eigen::Index samples : {1, 2, 5, 6, 7, 15, 16, 17, 47, 48, 49, 95, 96, 97, 144, 145})
    for (const double zero_share : {0.0, 0.5}) {
      SCOPED_TRACE(testing::Message() << samples << " samples");
      Trained trained = random_training(samples, 3, zero_share, generator);
      trained.beta(samples - 1) = -2;
      EXPECT_LT(worst_error(trained, 2), 1e-14);
    }
}

TEST(GaussianPairs, AreAccurateWhenLargeWeightsCancel) {
  std::mt19937_64 generator(2);
  Trained trained = random_training(1000, 8, 0, generator);
  for (Eigen::Index j = 0; j < 1000; ++j) trained.beta(j) = j % 2 == 0 ? 700 : -700;
  EXPECT_LT(worst_error(trained, 30) * trained.beta.lpNorm<1>(), 1e-10);
}

TEST(GaussianPairs, AreZeroWithoutWeightsOrSamples) {
  std::mt19937_64 generator(3);
  const Trained trained = random_training(60, 2, 1, generator);
  EXPECT_EQ(gaussian_response(trained.x, 1, trained.beta), Eigen::VectorXd::Zero(60));
  EXPECT_EQ(gaussian_response(trained.x.topRows(0), 1, trained.beta.head(0)).size(), 0);
  const SampleMatrix same = SampleMatrix::Constant(5, 0, 0);
  EXPECT_EQ(gaussian_response(same, 1, Eigen::VectorXd::Ones(5)), Eigen::VectorXd::Constant(5, 5));
}

}  // namespace
}  // namespace gyrotherm::svm
