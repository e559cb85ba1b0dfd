// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/gaussian_pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/analysis/svm/gaussian_formula.hpp"

namespace gyrotherm::svm {
namespace {

/// Samples away from the origin, and β of which a part is 0.
struct Trained {
  SampleMatrix x;
  Eigen::VectorXd beta;
};

Trained random_training(Eigen::Index samples, Eigen::Index inputs, double of_zeros, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  std::bernoulli_distribution zero(of_zeros);
  return {.x = SampleMatrix::NullaryExpr(samples, inputs, [&] { return 3 + normal(generator); }),
          .beta = Eigen::VectorXd::NullaryExpr(samples, [&] { return zero(generator) ? 0 : 10 * normal(generator); })};
}

/// The largest error, as a part of Σ|β|, with every instruction set that this processor has.
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

TEST(GaussianPairs, AreTheFormulaToTheBound) {
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

TEST(GaussianPairs, FillGroupsOfAnySize) {
  std::mt19937_64 generator(1);
  for (const Eigen::Index samples : {1, 2, 5, 6, 7, 15, 16, 17, 47, 48, 49, 95, 96, 97, 144, 145})
    for (const double of_zeros : {0.0, 0.5}) {
      SCOPED_TRACE(testing::Message() << samples << " samples");
      Trained trained = random_training(samples, 3, of_zeros, generator);
      trained.beta(samples - 1) = -2;
      EXPECT_LT(worst_error(trained, 2), 1e-14);
    }
}

TEST(GaussianPairs, LoseLittleWhereLargeWeightsCancel) {
  std::mt19937_64 generator(2);
  Trained trained = random_training(1000, 8, 0, generator);
  for (Eigen::Index j = 0; j < 1000; ++j) trained.beta(j) = j % 2 == 0 ? 700 : -700;
  EXPECT_LT(worst_error(trained, 30) * trained.beta.lpNorm<1>(), 1e-10);
}

TEST(GaussianPairs, OfNothingAreNothing) {
  std::mt19937_64 generator(3);
  const Trained trained = random_training(60, 2, 1, generator);
  EXPECT_EQ(gaussian_response(trained.x, 1, trained.beta), Eigen::VectorXd::Zero(60));
  EXPECT_EQ(gaussian_response(trained.x.topRows(0), 1, trained.beta.head(0)).size(), 0);
  const SampleMatrix same = SampleMatrix::Constant(5, 0, 0);
  EXPECT_EQ(gaussian_response(same, 1, Eigen::VectorXd::Ones(5)), Eigen::VectorXd::Constant(5, 5));
}

}  // namespace
}  // namespace gyrotherm::svm
