// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/input_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

Clusters run() { return *make_clusters(make_synthetic_run({})); }

TEST(InputCovariance, EqualsVariancesOfTemperatures) {
  const std::vector<double> u = {0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08};
  const Eigen::MatrixXd covariance =
      *input_covariance({temperature_term("A"), temperature_term("H"), gradient_term("A", "H")}, run(), u);
  Eigen::Matrix3d expected;
  expected << 1e-4, 0, 1e-4, 0, 64e-4, -64e-4, 1e-4, -64e-4, 65e-4;
  EXPECT_LT((covariance - expected).norm(), 1e-15);
}

TEST(InputCovariance, PropagatesLastMeanToRateAndLag) {
  const Clusters clusters = pick_clusters(run(), {5, 6, 7});
  const Eigen::MatrixXd covariance =
      *input_covariance({rate_term("A"), lag_term(600, "A")}, clusters, std::vector<double>(8, 0.05));
  EXPECT_NEAR(covariance(0, 0), std::pow(0.05 * 60 / 100, 2), 1e-15);
  EXPECT_NEAR(covariance(1, 1), std::pow(0.05 * std::exp(-100.0 / 600), 2), 1e-15);
  EXPECT_EQ(covariance(0, 1), 0);
}

/// The errors are small relative to the temperatures, so products of temperatures are nearly linear in them.
TEST(InputCovariance, MatchesSimulatedThermometerErrors) {
  const std::vector<Term> terms = {temperature_term("A"), gradient_term("A", "B"),
                                   temperature_term("A") * temperature_term("A"),
                                   temperature_term("A") * gradient_term("B", "C") * temperature_term("B")};
  const Clusters clusters = run();
  const std::vector<double> u = {1e-3, 2e-3, 3e-3, 1, 1, 1, 1, 1};
  const SampleMatrix exact = *evaluate(terms, clusters);
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd observed = Eigen::MatrixXd::Zero(4, 4);
  constexpr int kDraws = 400;
  for (int draw = 0; draw < kDraws; ++draw) {
    Clusters erring = clusters;
    for (Eigen::Index j = 0; j < 3; ++j)
      for (double& t : erring.temperature_c.col(j)) t += u[static_cast<std::size_t>(j)] * normal(generator);
    const Eigen::MatrixXd error = *evaluate(terms, erring) - exact;
    observed += error.transpose() * error / static_cast<double>(error.rows() * kDraws);
  }
  const Eigen::MatrixXd covariance = *input_covariance(terms, clusters, u);
  const Eigen::VectorXd std = covariance.diagonal().cwiseSqrt();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(observed(i, j), covariance(i, j), 0.02 * std(i) * std(j)) << i << ", " << j;
}

TEST(InputCovariance, RejectsInvalidUncertainties) {
  for (const std::vector<double>& u :
       {std::vector<double>{}, std::vector<double>{0.1}, std::vector<double>(8, -0.1), std::vector<double>(8, NAN)})
    EXPECT_EQ(input_covariance({temperature_term("A")}, run(), u).error().where, "uncertainty");
  EXPECT_TRUE(input_covariance({temperature_term("A")}, run(), std::vector<double>(8, 0))->isZero(0)) << "no error";
  EXPECT_FALSE(input_covariance({temperature_term("Z")}, run(), std::vector<double>(8, 0.05)));
}

}  // namespace
}  // namespace gyrotherm::data
