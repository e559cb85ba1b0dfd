// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/rate_fusion.hpp"

#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

TEST(RateFusion, InvertsDirectionsOfTriad) {
  const std::vector<InputAxis> axes = {axis("1", 1, 0, 0, 0.1), axis("2", 3, 4, 0, 0.2), axis("3", 0, 3, 4, 0.3)};
  const Gains gains = compute_gains(valid_geometry(axes));
  // Computed by hand: x = y₁; 0.6 x + 0.8 y = y₂; 0.6 y + 0.8 z = y₃.
  Eigen::Matrix3d expected;
  expected << 1, 0, 0, -0.75, 1.25, 0, 0.5625, -0.9375, 1.25;
  EXPECT_TRUE(gains.rate.isApprox(expected, 1e-14)) << gains.rate;
  EXPECT_EQ(gains.parity.rows(), 0);
  const Eigen::Vector3d variances(0.01, 0.04, 0.09);
  EXPECT_TRUE(gains.covariance.isApprox(expected * variances.asDiagonal() * expected.transpose(), 1e-13));
}

/// For h = (1, 1, 1)/√3, HᵀH = I + hhᵀ, and its inverse is I − hhᵀ/2.
TEST(RateFusion, MatchesManualComputationForTetrad) {
  const double u = 0.02, root = std::sqrt(3.0);
  const Gains gains = compute_gains(valid_geometry(tetrad_axes(u)));
  const Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity() - Eigen::Matrix3d::Constant(1.0 / 6);
  EXPECT_TRUE(gains.covariance.isApprox(u * u * inverse, 1e-13)) << gains.covariance;
  Eigen::Matrix<double, 3, 4> expected;
  expected << inverse, Eigen::Vector3d::Constant(0.5 / root);
  EXPECT_TRUE(gains.rate.isApprox(expected, 1e-13)) << gains.rate;
  // The only relation is x + y + z = √3 skew.
  ASSERT_EQ(gains.parity.rows(), 1);
  const Eigen::RowVector4d relation = Eigen::RowVector4d(1, 1, 1, -root) / (std::sqrt(6.0) * u);
  EXPECT_NEAR(std::abs(gains.parity.row(0).dot(relation)), relation.squaredNorm(), 1e-9);
  EXPECT_NEAR(gains.parity.norm(), relation.norm(), 1e-9);
  const Eigen::Vector4d readings(10, -5, 2, 7 / root);
  EXPECT_TRUE(fuse_readings(gains, readings).deg_per_h.isApprox(Eigen::Vector3d(10, -5, 2), 1e-13));
}

TEST(RateFusion, IsBestLinearUnbiasedEstimate) {
  const Geometry geometry = valid_geometry(uneven_axes());
  const Gains gains = compute_gains(geometry);
  const Eigen::MatrixXd h = geometry.directions, inverse = geometry.covariance.inverse();
  const Eigen::Matrix3d normal = h.transpose() * inverse * h;
  EXPECT_TRUE(gains.rate.isApprox(normal.inverse() * h.transpose() * inverse, 1e-11));
  EXPECT_TRUE(gains.covariance.isApprox(normal.inverse(), 1e-11));
  EXPECT_TRUE((gains.rate * h).isIdentity(1e-12)) << "unbiased";
  EXPECT_TRUE((gains.rate * geometry.covariance * gains.rate.transpose()).isApprox(gains.covariance, 1e-11));
}

TEST(RateFusion, HasWhiteParityIndependentOfRate) {
  for (const auto& axes : {tetrad_axes(0.01), dodecahedron_axes(0.3), uneven_axes()}) {
    const Geometry geometry = valid_geometry(axes);
    const Gains gains = compute_gains(geometry);
    EXPECT_EQ(gains.parity.rows(), geometry.axes() - 3);
    EXPECT_LT((gains.parity * geometry.directions).norm(), 1e-12 * gains.parity.norm());
    EXPECT_TRUE((gains.parity * geometry.covariance * gains.parity.transpose()).isIdentity(1e-10));
    EXPECT_LT((gains.parity * geometry.covariance * gains.rate.transpose()).norm(), 1e-12) << "independent of the rate";
  }
}

/// Compares the covariance of the errors with the stated one for 20 seeds of 5000 readings each. The tolerance is 4.5
/// standard errors of a variance for each seed, and four for the mean over the seeds.
TEST(RateFusion, HasStatedCovariance) {
  const Geometry geometry = valid_geometry(uneven_axes());
  const Gains gains = compute_gains(geometry);
  const Eigen::Vector3d truth(12, -3, 40);
  constexpr int kReadings = 5000;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d whitening = gains.covariance.llt().matrixL().solve(Eigen::Matrix3d::Identity());
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    Eigen::Matrix3d measured = Eigen::Matrix3d::Zero();
    for (int n = 0; n < kReadings; ++n) {
      const Eigen::VectorXd readings = geometry.directions * truth + draws.correlated_normal(geometry.covariance);
      const Eigen::Vector3d error = whitening * (fuse_readings(gains, readings).deg_per_h - truth);
      measured += error * error.transpose() / kReadings;
    }
    EXPECT_LT((measured - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 4.5 * std::sqrt(2.0 / kReadings))
        << "seed " << seed;
    mean += measured / kSeeds;
  }
  EXPECT_LT((mean - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 4 * std::sqrt(2.0 / (kReadings * kSeeds)));
}

TEST(RateFusion, MatchesReducedGeometryWhenAxisIsOmitted) {
  const Geometry geometry = valid_geometry(uneven_axes());
  const Gains gains = compute_gains(geometry);
  Draws draws(3);
  for (Eigen::Index out = 0; out < geometry.axes(); ++out) {
    const Eigen::VectorXd readings = 30 * draws.normal(geometry.axes());
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < geometry.axes(); ++i)
      if (i != out) kept.push_back(i);
    const FusedRate expected = fuse_readings(compute_gains(*remove_axis(geometry, out)), readings(kept));
    const auto rest = fuse_without_axis(gains, readings, out);
    ASSERT_TRUE(rest);
    EXPECT_TRUE(rest->deg_per_h.isApprox(expected.deg_per_h, 1e-10)) << out;
    EXPECT_TRUE(rest->covariance.isApprox(expected.covariance, 1e-10)) << out;
    Eigen::VectorXd broken = readings;
    broken(out) += 1000;
    EXPECT_TRUE(fuse_without_axis(gains, broken, out)->deg_per_h.isApprox(expected.deg_per_h, 1e-10));
  }
}

TEST(RateFusion, RemainsUnbiasedWithOtherWeightsWhenAxisIsOmitted) {
  const Geometry geometry = valid_geometry(uneven_axes());
  Geometry weights = geometry;
  weights.covariance = Eigen::VectorXd::LinSpaced(6, 1, 30).asDiagonal();
  const Gains gains = weighted_gains(geometry, weights);
  const Eigen::Vector3d rate(3, -7, 11);
  for (Eigen::Index out = 0; out < geometry.axes(); ++out) {
    Eigen::VectorXd readings = geometry.directions * rate;
    readings(out) += 100;
    const auto rest = fuse_without_axis(gains, readings, out);
    ASSERT_TRUE(rest);
    EXPECT_TRUE(rest->deg_per_h.isApprox(rate, 1e-10)) << "axis " << out;
  }
}

TEST(RateFusion, RefusesToOmitAxisWithoutRedundancy) {
  const Gains gains = compute_gains(
      valid_geometry({axis("1", 1, 0, 0, 1), axis("2", 0, 1, 0, 1), axis("3", 1, 1, 0, 1), axis("up", 0, 0, 1, 1)}));
  const Eigen::Vector4d readings(1, 2, 2, 3);
  EXPECT_TRUE(fuse_without_axis(gains, readings, 1));
  const auto rest = fuse_without_axis(gains, readings, 3);
  ASSERT_FALSE(rest);
  EXPECT_EQ(rest.error().kind, FaultKind::numeric);
  EXPECT_FALSE(fuse_without_axis(compute_gains(valid_geometry(triad_axes(1))), Eigen::Vector3d(1, 2, 3), 0));
}

}  // namespace
}  // namespace gyrotherm::fusion
