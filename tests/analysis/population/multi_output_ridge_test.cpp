// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/multi_output_ridge.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "analysis/methods/ridge_u.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::population {
namespace {

using data::normal_matrix;

Eigen::MatrixXd positive_matrix(Eigen::Index size, std::uint64_t seed) {
  const Eigen::MatrixXd root = normal_matrix(size, size, seed);
  return root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(size, size);
}

struct Outputs {
  Eigen::MatrixXd z, y, penalty;
};
Outputs some_outputs(std::uint64_t seed) {
  Outputs outputs{normal_matrix(30, 4, seed), {}, 0.05 * positive_matrix(4, seed + 100)};
  outputs.y = outputs.z * normal_matrix(4, 3, seed + 200) + normal_matrix(30, 3, seed + 300);
  outputs.y.rowwise() += Eigen::RowVector3d(1, -2, 3);
  return outputs;
}

TEST(MultiOutputRidge, SolvesNormalEquations) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Outputs o = some_outputs(seed);
    const OutputCovariances between{positive_matrix(3, seed + 1), positive_matrix(3, seed + 2)};
    const auto planes = multi_output_ridge(o.z, o.y, o.penalty, between);
    ASSERT_TRUE(planes);
    const Eigen::MatrixXd z = o.z.rowwise() - o.z.colwise().mean(), y = o.y.rowwise() - o.y.colwise().mean();
    const Eigen::MatrixXd& w = planes->weights;
    const Eigen::MatrixXd left = z.transpose() * (y - z * w) * between.noise.inverse();
    const Eigen::MatrixXd right = 30 * o.penalty * w * between.slopes.inverse();
    EXPECT_LT((left - right).norm(), 1e-9 * right.norm());
    EXPECT_LT((planes->b - (o.y.colwise().mean() - o.z.colwise().mean() * w)).norm(), 1e-10);
  }
}

/// Computes the posterior mean of all slopes at once, with Kronecker products.
TEST(MultiOutputRidge, EqualsPosteriorMeanOfWholeSystem) {
  const Outputs o = some_outputs(3);
  const OutputCovariances between{positive_matrix(3, 4), positive_matrix(3, 5)};
  const Eigen::MatrixXd z = o.z.rowwise() - o.z.colwise().mean(), y = o.y.rowwise() - o.y.colwise().mean();
  const Eigen::MatrixXd noise = between.noise.inverse(), slopes = between.slopes.inverse();
  Eigen::MatrixXd system(12, 12);
  Eigen::VectorXd target(12);
  const Eigen::MatrixXd weighed = z.transpose() * y * noise;
  for (Eigen::Index i = 0; i < 3; ++i) {
    target.segment(4 * i, 4) = weighed.col(i);
    for (Eigen::Index j = 0; j < 3; ++j)
      system.block(4 * i, 4 * j, 4, 4) = noise(i, j) * z.transpose() * z + 30 * slopes(i, j) * o.penalty;
  }
  const Eigen::VectorXd solution = system.ldlt().solve(target);
  const auto planes = multi_output_ridge(o.z, o.y, o.penalty, between);
  ASSERT_TRUE(planes);
  EXPECT_LT((planes->weights.reshaped() - solution).norm(), 1e-9 * solution.norm());
}

/// Requires that each output has the plane of its own ridge regression with penalties(j) times the penalty.
void expect_separate_ridges(const Outputs& o, const OutputCovariances& between, const Eigen::Vector3d& penalties) {
  const auto planes = multi_output_ridge(o.z, o.y, o.penalty, between);
  ASSERT_TRUE(planes);
  for (Eigen::Index j = 0; j < 3; ++j) {
    const auto plane = methods::penalised_plane(o.z, o.y.col(j), penalties(j) * o.penalty);
    EXPECT_LT((planes->weights.col(j) - plane.weights).norm(), 1e-10) << j;
    EXPECT_NEAR(planes->b(j), plane.b, 1e-10) << j;
  }
}

TEST(MultiOutputRidge, EqualsSeparateRidgesWhenCorrelationsCannotHelp) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Outputs o = some_outputs(seed);
    const Eigen::MatrixXd noise = positive_matrix(3, seed);
    const Eigen::Vector3d variances(0.5, 2, 7), slopes(1, 3, 0.2);
    expect_separate_ridges(o, {2.5 * noise, noise}, Eigen::Vector3d::Constant(2.5));  // proportional
    expect_separate_ridges(o, {variances.asDiagonal(), slopes.asDiagonal()}, variances.cwiseQuotient(slopes));
    // Zellner's theorem: all equations have the same inputs.
    o.penalty.setZero();
    expect_separate_ridges(o, {noise, Eigen::Matrix3d::Identity()}, Eigen::Vector3d::Zero());
  }
}

/// Uses 30 rows for eight inputs, strongly correlated noise, and uncorrelated slopes.
TEST(MultiOutputRidge, ReducesErrorWhenOnlyNoiseIsCorrelated) {
  Eigen::Matrix3d noise = Eigen::Matrix3d::Constant(4 * 0.9);
  noise.diagonal().setConstant(4);
  const Eigen::Matrix3d root = noise.llt().matrixL(), identity = Eigen::Matrix3d::Identity();
  double separate = 0, together = 0, estimated = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Eigen::MatrixXd z = normal_matrix(30, 8, seed), slopes = normal_matrix(8, 3, seed + 1000);
    const Eigen::MatrixXd y = z * slopes + normal_matrix(30, 3, seed + 2000) * root.transpose();
    const Eigen::MatrixXd penalty = Eigen::MatrixXd::Identity(8, 8) / 30;
    separate += (multi_output_ridge(z, y, penalty, {4 * identity, identity})->weights - slopes).squaredNorm();
    together += (multi_output_ridge(z, y, penalty, {noise, identity})->weights - slopes).squaredNorm();
    estimated += (multi_output_ridge(z, y, penalty)->planes.weights - slopes).squaredNorm();
  }
  EXPECT_LT(together, 0.85 * separate);
  EXPECT_LT(estimated, 0.9 * separate);
}

TEST(MultiOutputRidge, EstimatesNoiseCovarianceOfOutputs) {
  const Eigen::Matrix3d noise = positive_matrix(3, 8);
  const Eigen::Matrix3d root = noise.llt().matrixL();
  const Eigen::MatrixXd z = normal_matrix(4000, 4, 1);
  const Eigen::MatrixXd y = z * normal_matrix(4, 3, 2) + normal_matrix(4000, 3, 3) * root.transpose();
  const auto found = multi_output_ridge(z, y, Eigen::MatrixXd::Identity(4, 4) / 4000);
  ASSERT_TRUE(found);
  EXPECT_LT((found->noise - noise).norm(), 0.06 * noise.norm());
}

TEST(MultiOutputRidge, RejectsInconsistentInputs) {
  const Outputs o = some_outputs(1);
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const auto kind_of = [](const auto& result) { return result ? FaultKind::timeout : result.error().kind; };
  EXPECT_EQ(kind_of(multi_output_ridge(o.z.topRows(10), o.y, o.penalty, {identity, identity})), FaultKind::usage);
  EXPECT_EQ(kind_of(multi_output_ridge(o.z, o.y, identity, {identity, identity})), FaultKind::usage);
  EXPECT_EQ(kind_of(multi_output_ridge(o.z, o.y, o.penalty, {Eigen::Matrix2d::Identity(), identity})),
            FaultKind::usage);
  EXPECT_EQ(kind_of(multi_output_ridge(o.z, o.y, o.penalty, {-identity, identity})), FaultKind::numeric);
  EXPECT_EQ(kind_of(multi_output_ridge(o.z.topRows(5), o.y.topRows(5), 0 * o.penalty)), FaultKind::usage);
  Outputs broken = o;
  broken.y(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kind_of(multi_output_ridge(broken.z, broken.y, broken.penalty)), FaultKind::usage);
}

}  // namespace
}  // namespace gyrotherm::population
