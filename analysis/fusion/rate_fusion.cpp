// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/rate_fusion.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cassert>

namespace gyrotherm::fusion {

Gains compute_gains(const Geometry& geometry) {
  const Eigen::Index axes = geometry.axes();
  assert(axes >= 3);
  const Eigen::MatrixXd lower = geometry.covariance.llt().matrixL();
  const auto triangle = lower.triangularView<Eigen::Lower>();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(triangle.solve(Eigen::MatrixXd(geometry.directions)));
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(axes, axes);
  const Eigen::MatrixXd whitening = triangle.solve(Eigen::MatrixXd::Identity(axes, axes));
  const Eigen::Matrix3d r = qr.matrixQR().topRows<3>().triangularView<Eigen::Upper>();
  const Eigen::Matrix3d inverse = r.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity());
  return {.rate = inverse * q.leftCols<3>().transpose() * whitening,
          .covariance = inverse * inverse.transpose(),
          .parity = q.rightCols(axes - 3).transpose() * whitening};
}

Gains weighted_gains(const Geometry& geometry, const Geometry& weights) {
  assert(geometry.axes() == weights.axes());
  Gains gains = compute_gains(geometry);
  gains.rate = compute_gains(weights).rate;
  gains.covariance = gains.rate * geometry.covariance * gains.rate.transpose();
  return gains;
}

FusedRate fuse_readings(const Gains& gains, const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h) {
  return {gains.rate * readings_deg_per_h, gains.covariance};
}

Result<FusedRate> fuse_without_axis(const Gains& gains, const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h,
                                    Eigen::Index axis) {
  const Eigen::VectorXd effect = gains.parity.col(axis);
  const double square = effect.squaredNorm();
  const Eigen::Vector3d reach = gains.rate.col(axis);
  const double redundancy = square / (square + reach.dot(gains.covariance.llt().solve(reach)));
  if (redundancy < kLeastRedundancy)
    return failure(FaultKind::numeric, fmt::format("axis {}", axis + 1), "no other axis measures this component");
  const double bias = effect.dot(gains.parity * readings_deg_per_h) / square;
  return FusedRate{.deg_per_h = gains.rate * readings_deg_per_h - bias * reach,
                   .covariance = gains.covariance + reach * reach.transpose() / square};
}

FaultTest parity_test(const Gains& gains, const Geometry& geometry) { return {geometry.names, gains.parity}; }

}  // namespace gyrotherm::fusion
