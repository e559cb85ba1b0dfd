// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

namespace gyrotherm::svm {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

/// The orders 1 to 67 cover every remainder of the tile size and of the leaf. Larger orders have several blocks.
TEST(Cholesky, ReproducesMatrixAtEveryOrder) {
  std::vector<Eigen::Index> orders = {191, 192, 193, 255, 257, 400, 521};
  for (Eigen::Index n = 1; n <= 67; ++n) orders.push_back(n);
  for (const Eigen::Index n : orders) {
    SCOPED_TRACE(n);
    const Eigen::MatrixXd half = random_matrix(n, n, 1);
    const Eigen::MatrixXd a = half * half.transpose() + Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd factor = a;
    ASSERT_TRUE(factor_cholesky(factor));
    const Eigen::MatrixXd lower = factor.triangularView<Eigen::Lower>();
    EXPECT_LT((lower * lower.transpose() - a).cwiseAbs().maxCoeff(), 1e-13 * a.cwiseAbs().maxCoeff());
  }
}

TEST(Cholesky, SolvesForEveryColumn) {
  const Eigen::MatrixXd half = random_matrix(100, 100, 2);
  const Eigen::MatrixXd a = half * half.transpose() + Eigen::MatrixXd::Identity(100, 100);
  const Eigen::MatrixXd expected = random_matrix(100, 2, 3);
  Eigen::MatrixXd factor = a;
  ASSERT_TRUE(factor_cholesky(factor));
  Eigen::MatrixXd b = a * expected;
  solve_cholesky(factor, b);
  EXPECT_LT((b - expected).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Cholesky, InvertsMatrixAndDiagonal) {
  for (const Eigen::Index n : {1, 5, 24, 25, 100, 193, 400}) {
    SCOPED_TRACE(n);
    const Eigen::MatrixXd half = random_matrix(n, n, 4);
    const Eigen::MatrixXd a = half * half.transpose() + Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd factor = a;
    ASSERT_TRUE(factor_cholesky(factor));
    const Eigen::MatrixXd lower = inverse_lower(factor);
    const Eigen::MatrixXd inverse = lower.selfadjointView<Eigen::Lower>();
    EXPECT_LT((a * inverse - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((inverse_diagonal(factor) - inverse.diagonal()).cwiseAbs().maxCoeff(), 1e-11);
  }
}

TEST(Cholesky, SubtractsSquareOfAnyShape) {
  for (const auto& [rows, columns] : {std::pair{1, 1}, {7, 300}, {50, 3}, {221, 1662}}) {
    const Eigen::MatrixXd a = random_matrix(rows, columns, 5), c = random_matrix(rows, rows, 6);
    Eigen::MatrixXd result = c;
    subtract_square(a, result);
    const Eigen::MatrixXd expected = c - a * a.transpose();
    const Eigen::MatrixXd difference = (result - expected).triangularView<Eigen::Lower>();
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-10) << rows << " x " << columns;
  }
}

TEST(Cholesky, RejectsMatrixThatIsNotPositiveDefinite) {
  for (const Eigen::Index n : {1, 30, 300}) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Identity(n, n);
    a(n - 1, n - 1) = -1;
    EXPECT_FALSE(factor_cholesky(a));
    a = Eigen::MatrixXd::Constant(n, n, std::nan(""));
    EXPECT_FALSE(factor_cholesky(a));
  }
}

}  // namespace
}  // namespace gyrotherm::svm
