// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/spanned.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gyrotherm::svm {
namespace {

SampleMatrix random_matrix(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  return SampleMatrix::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

double greatest_distance_change(const SampleMatrix& x, const Eigen::MatrixXd& coordinates) {
  double greatest = 0;
  for (Eigen::Index i = 1; i < x.rows(); ++i)
    greatest =
        std::max(greatest, std::abs((x.row(i) - x.row(0)).norm() - (coordinates.row(i) - coordinates.row(0)).norm()));
  return greatest;
}

TEST(Spanned, KeepsSamplesOfIndependentInputs) {
  for (const Eigen::Index rows : {14, 52, 53, 600}) {
    const SampleMatrix x = random_matrix(rows, 13);
    EXPECT_EQ(project_to_span(x), Eigen::MatrixXd(x)) << rows;
  }
}

TEST(Spanned, ReducesDependentInputsAndKeepsDistances) {
  for (const Eigen::Index rows : {9, 60, 600}) {
    const SampleMatrix x = random_matrix(rows, 7) * random_matrix(7, 13);
    const Eigen::MatrixXd coordinates = project_to_span(x);
    EXPECT_EQ(coordinates.cols(), 7) << rows;
    EXPECT_LT(greatest_distance_change(x, coordinates), 1e-13 * x.norm()) << rows;
  }
}

TEST(Spanned, LimitsDimensionsToSampleCount) {
  const SampleMatrix x = random_matrix(5, 13);
  const Eigen::MatrixXd coordinates = project_to_span(x);
  EXPECT_EQ(coordinates.cols(), 4) << "one dimension is lost by centring";
  EXPECT_LT(greatest_distance_change(x, coordinates), 1e-13 * x.norm());
}

TEST(Spanned, FindsDirectionInLaterSamples) {
  SampleMatrix x = random_matrix(600, 5);
  x.col(4).head(500).setConstant(2);
  EXPECT_EQ(project_to_span(x).cols(), 5);
}

TEST(Spanned, HasNoDimensionForEqualSamples) {
  EXPECT_EQ(project_to_span(SampleMatrix::Constant(100, 5, 3)).cols(), 0);
  EXPECT_EQ(project_to_span(SampleMatrix(0, 5)).rows(), 0);
}

TEST(Spanned, ReturnsOrthonormalDirections) {
  const Eigen::MatrixXd x = random_matrix(300, 4) * random_matrix(4, 9);
  const Eigen::MatrixXd basis = spanning_directions(x.rowwise() - x.colwise().mean());
  EXPECT_LT((basis.transpose() * basis - Eigen::MatrixXd::Identity(4, 4)).norm(), 1e-14);
}

}  // namespace
}  // namespace gyrotherm::svm
