// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/correlated_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <random>

namespace gyrotherm::data {
namespace {

constexpr double kLengthS = 100;
constexpr int kLongest = 54;  ///< 90 min

/// Noise of variance 1 with the correlation `memory` between neighbours.
Eigen::VectorXd correlated_noise(Eigen::Index rows, double memory, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::VectorXd values(rows);
  double value = normal(random);
  for (double& at : values) {
    at = value;
    value = memory * value + std::sqrt(1 - memory * memory) * normal(random);
  }
  return values;
}

Eigen::VectorXi consecutive(Eigen::Index rows) {
  return Eigen::VectorXi::LinSpaced(rows, 0, static_cast<int>(rows) - 1);
}

/// Constant, temperature and rate of a block with a time constant of 300 s in an oven that warms up and cools down
/// once.
Eigen::MatrixXd single_cycle(Eigen::Index rows) {
  Eigen::MatrixXd x(rows, 3);
  double block_c = 22, before_c = 22;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(rows);
    const double oven_c = 22 + 18 * (1 - std::abs(2 * part - 1));
    block_c += (1 - std::exp(-kLengthS / 300)) * (oven_c - block_c);
    x.row(k) << 1, block_c, (block_c - before_c) / kLengthS * 60;
    before_c = block_c;
  }
  return x;
}

/// Returns the root mean square of value/u of the rate, whose true coefficient is 0.
double calibration(Eigen::Index rows, double memory) {
  constexpr int kSeeds = 100;
  const Eigen::MatrixXd x = single_cycle(rows);
  std::mt19937_64 random(79);
  double squares = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const CorrelatedFit fit =
        fit_with_correlated_noise(x, correlated_noise(rows, memory, random), consecutive(rows), kLongest);
    squares += std::pow(fit.coefficients(2) / fit.u(2), 2);
  }
  return std::sqrt(squares / kSeeds);
}

TEST(CorrelatedFit, IsCalibratedForWhiteNoiseInShortRecords) {
  for (const Eigen::Index rows : {108, 216, 432}) {  // 3, 6 and 12 h
    const double rms = calibration(rows, 0);
    EXPECT_GT(rms, 0.75) << rows;
    EXPECT_LT(rms, 1.15) << rows;
  }
}

/// Correlation times of 950 s and 2760 s. A sum of products over 90 min gives 2.5 and more.
TEST(CorrelatedFit, IsCalibratedForCorrelatedNoiseInShortRecords) {
  for (const Eigen::Index rows : {108, 216, 432})
    for (const double memory : {0.9, std::exp(-100.0 / 2760)}) {
      const double rms = calibration(rows, memory);
      EXPECT_GT(rms, 0.6) << rows << " rows, memory " << memory;
      EXPECT_LT(rms, 1.25) << rows << " rows, memory " << memory;
    }
}

TEST(CorrelatedFit, EqualsClassicalErrorInLongWhiteRecord) {
  constexpr Eigen::Index kRows = 3000;
  std::mt19937_64 random(3);
  const Eigen::MatrixXd x = single_cycle(kRows);
  const Eigen::VectorXd y = 5 * x.col(2) + correlated_noise(kRows, 0, random);
  const CorrelatedFit fit = fit_with_correlated_noise(x, y, consecutive(kRows), kLongest);
  EXPECT_LT((fit.coefficients - x.colPivHouseholderQr().solve(y)).norm(), 1e-9);
  EXPECT_LT((fit.residual - (y - x * fit.coefficients)).norm(), 1e-9);
  const Eigen::VectorXd classical = (x.transpose() * x).inverse().diagonal().cwiseSqrt();
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(fit.u(k) / classical(k), 1, 0.15) << k;
}

/// Values of a far position add information that neighbours do not add.
TEST(CorrelatedFit, UsesPositionsAcrossGaps) {
  constexpr Eigen::Index kRows = 200;
  std::mt19937_64 random(11);
  const Eigen::VectorXd y = correlated_noise(kRows, 0.95, random);
  const Eigen::MatrixXd x = Eigen::MatrixXd::Ones(kRows, 1);
  const double dense = fit_with_correlated_noise(x, y, consecutive(kRows), kLongest).u(0);
  Eigen::VectorXi with_gap = consecutive(kRows);
  with_gap.tail(kRows / 2).array() += 100000;
  const double gap = fit_with_correlated_noise(x, y, with_gap, kLongest).u(0);
  EXPECT_TRUE(std::isfinite(gap));
  EXPECT_LT(gap, 1.1 * dense);
  const double apart = fit_with_correlated_noise(x, y, 1000 * consecutive(kRows), kLongest).u(0);
  EXPECT_NEAR(
      apart,
      std::sqrt(fit_with_correlated_noise(x, y, consecutive(kRows), 0).residual.squaredNorm() / (kRows - 1.0) / kRows),
      0.05 * apart)
      << "values that are far apart are independent";
}

TEST(CorrelatedFit, HasNoErrorWithoutNoise) {
  const Eigen::MatrixXd x = single_cycle(108);
  const CorrelatedFit exact = fit_with_correlated_noise(x, x * Eigen::Vector3d(1, 2, 3), consecutive(108), kLongest);
  EXPECT_LT((exact.coefficients - Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
  EXPECT_LT(exact.u.maxCoeff(), 1e-9);
  const CorrelatedFit zero = fit_with_correlated_noise(x, Eigen::VectorXd::Zero(108), consecutive(108), kLongest);
  EXPECT_TRUE(zero.u.allFinite());
  EXPECT_LT(zero.u.maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace gyrotherm::data
