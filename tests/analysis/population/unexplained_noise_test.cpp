// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/unexplained_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::population {
namespace {

TEST(UnexplainedNoise, IsWhitenedLikeByCholeskyFactorOfCovariance) {
  Eigen::VectorXd time(40);
  for (Eigen::Index k = 0; k < time.size(); ++k)
    time(k) = 100.0 * static_cast<double>(k) + (k >= 15 ? 5000 : 0) + (k >= 30 ? 1e6 : 0);  // gaps
  for (const UnexplainedNoise& noise : {UnexplainedNoise{0.002, 0.003, 3000, 0.001}, UnexplainedNoise{0.5, 0, 1, 0},
                                        UnexplainedNoise{0.001, 0.05, 1e5, 0}, UnexplainedNoise{1, 0, 100, 3}}) {
    const Eigen::LLT<Eigen::MatrixXd> factor(noise_covariance(noise, time));
    const Eigen::MatrixXd columns = data::normal_matrix(40, 3, 5);
    const WhitenedColumns whitened = whiten(noise, time, columns);
    const Eigen::MatrixXd expected = factor.matrixL().solve(columns);
    EXPECT_LT((whitened.columns - expected).norm() / expected.norm(), 1e-9);
    EXPECT_NEAR(whitened.log_determinant, 2 * factor.matrixLLT().diagonal().array().log().sum(), 1e-8);
  }
}

TEST(UnexplainedNoise, IsEmptyWithoutRows) {
  const WhitenedColumns whitened = whiten({1, 1, 1, 1}, Eigen::VectorXd(0), Eigen::MatrixXd(0, 2));
  EXPECT_EQ(whitened.columns.rows(), 0);
  EXPECT_EQ(whitened.log_determinant, 0);
}

}  // namespace
}  // namespace gyrotherm::population
