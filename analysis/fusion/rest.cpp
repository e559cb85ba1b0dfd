// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/rest.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/data/distributions.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::fusion {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0, -v(2), v(1), v(2), 0, -v(0), -v(1), v(0), 0).finished();
}

Eigen::Matrix3d rotation_by(const Eigen::Vector3d& angle) {
  const double size = angle.norm();
  return size == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                   : Eigen::AngleAxisd(size, angle / size).toRotationMatrix();
}

/// Returns J with exp([(ψ + δ)×]) = exp([(J δ)×]) exp([ψ×]), to first order in δ.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& angle) {
  const double size = angle.norm();
  constexpr double kSeriesAngle_rad = 1e-4;
  const double first = size < kSeriesAngle_rad ? 0.5 : (1 - std::cos(size)) / (size * size);
  const double second = size < kSeriesAngle_rad ? 1.0 / 6 : (size - std::sin(size)) / (size * size * size);
  const Eigen::Matrix3d times = cross(angle);
  return Eigen::Matrix3d::Identity() + first * times + second * times * times;
}

Result<void> check(const Geometry& geometry, const Attitude& attitude, const BiasPrior& prior) {
  const auto refuse = [](std::string what) { return failure(FaultKind::usage, "axes at rest", std::move(what)); };
  const Eigen::Index axes = geometry.axes();
  if (prior.mean_deg_per_h.size() != axes || prior.covariance.rows() != axes || prior.covariance.cols() != axes)
    return refuse(fmt::format("expected biases of {} axes, got {}", axes, prior.mean_deg_per_h.size()));
  if (!prior.mean_deg_per_h.allFinite() || !prior.covariance.allFinite()) return refuse("a bias is not finite");
  for (const double std : {attitude.tilt_std_deg, attitude.azimuth_std_deg, attitude.latitude_std_deg})
    if (!std::isfinite(std) || std < 0)
      return refuse(fmt::format("an uncertainty of an angle is {}°, expected at least 0", std));
  if (!attitude.turn_covariance_deg2.allFinite()) return refuse("a covariance of angles is not finite");
  constexpr double kPole = 90;
  if (!(std::abs(attitude.latitude_deg) <= kPole))
    return refuse(fmt::format("the latitude is {}°", attitude.latitude_deg));
  constexpr double kRounding = 1e-6;
  if (const Eigen::Matrix3d& r = attitude.to_local;
      !r.allFinite() || !(r * r.transpose()).isIdentity(kRounding) || r.determinant() < 0)
    return refuse("the attitude is not a rotation");
  return {};
}

/// Computes the covariance of the angles about north, east and down, rad². An error of the latitude is equivalent to a
/// rotation about east.
Eigen::Matrix3d angle_covariance(const Attitude& attitude) {
  Eigen::Matrix3d covariance = pose_covariance(attitude);
  covariance(1, 1) += std::pow(kRadians * attitude.latitude_std_deg, 2);
  return covariance;
}

/// Earth rate on the axes for a fixture rotated by ψ, and its derivative with respect to ψ.
struct EarthOnAxes {
  Eigen::VectorXd deg_per_h;
  Eigen::MatrixX3d by_angle;  ///< °/h per rad
};
EarthOnAxes earth_on_axes(const Geometry& geometry, const Attitude& attitude, const Eigen::Vector3d& angle) {
  const Eigen::Matrix3d back = rotation_by(angle).transpose();
  const Eigen::Vector3d earth = earth_rate(attitude.latitude_deg);
  const Eigen::MatrixX3d local = geometry.directions * attitude.to_local.transpose();
  return {local * (back * earth), local * back * cross(earth) * left_jacobian(angle)};
}

}  // namespace

Eigen::Matrix3d pose_covariance(const Attitude& attitude) {
  const Eigen::Vector3d deg(attitude.tilt_std_deg, attitude.tilt_std_deg, attitude.azimuth_std_deg);
  return kRadians * kRadians * (attitude.turn_covariance_deg2 + Eigen::Matrix3d(deg.cwiseAbs2().asDiagonal()));
}

Eigen::Matrix3d level_fixture(double heading_deg) {
  return Eigen::AngleAxisd(heading_deg * kRadians, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Eigen::Vector3d earth_rate(double latitude_deg) {
  const double latitude = latitude_deg * kRadians;
  return kEarthRateDegPerHour * Eigen::Vector3d(std::cos(latitude), 0, -std::sin(latitude));
}

Result<RestEstimate> estimate_at_rest(const Geometry& geometry,
                                      const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h,
                                      const Attitude& attitude, const BiasPrior& prior) {
  if (auto checked = check(geometry, attitude, prior); !checked) return failure(checked.error());
  if (readings_deg_per_h.size() != geometry.axes() || !readings_deg_per_h.allFinite())
    return failure(FaultKind::usage, "axes at rest", "a reading is missing");
  constexpr int kMostIterations = 50;
  constexpr double kConverged_rad = 1e-13;
  const Eigen::Matrix3d angles = angle_covariance(attitude);
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();
  double step = 0;
  for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
    const EarthOnAxes seen = earth_on_axes(geometry, attitude, angle);
    const Eigen::VectorXd innovation =
        readings_deg_per_h - seen.deg_per_h - prior.mean_deg_per_h + seen.by_angle * angle;
    // Covariance of readings and angles, before using the readings.
    const Eigen::MatrixXd reach = seen.by_angle * angles;
    const Eigen::LLT<Eigen::MatrixXd> expected(geometry.covariance + prior.covariance +
                                               reach * seen.by_angle.transpose());
    const Eigen::VectorXd weighted = expected.solve(innovation);
    const Eigen::Vector3d next = reach.transpose() * weighted;
    step = (next - angle).norm();
    angle = next;
    if (step > kConverged_rad) continue;
    return RestEstimate{.bias_deg_per_h = prior.mean_deg_per_h + prior.covariance * weighted,
                        .bias_covariance = prior.covariance - prior.covariance * expected.solve(prior.covariance),
                        .rotation_rad = angle,
                        .rotation_covariance = angles - reach.transpose() * expected.solve(reach),
                        .cross_covariance = -prior.covariance * expected.solve(reach),
                        .statistic = innovation.dot(weighted),
                        .iterations = iteration};
  }
  return failure(
      FaultKind::numeric, "axes at rest",
      fmt::format("the attitude did not converge in {} steps; last correction {:.3g} rad", kMostIterations, step));
}

Result<RestTest> rest_test(const Geometry& geometry, const Attitude& attitude, const BiasPrior& prior) {
  if (auto checked = check(geometry, attitude, prior); !checked) return failure(checked.error());
  const EarthOnAxes seen = earth_on_axes(geometry, attitude, Eigen::Vector3d::Zero());
  const Eigen::MatrixXd expected =
      geometry.covariance + prior.covariance + seen.by_angle * angle_covariance(attitude) * seen.by_angle.transpose();
  const Eigen::MatrixXd whitening =
      expected.llt().matrixL().solve(Eigen::MatrixXd::Identity(geometry.axes(), geometry.axes()));
  return RestTest{.whitening = whitening,
                  .expected_deg_per_h = seen.deg_per_h + prior.mean_deg_per_h,
                  .test = {geometry.names, whitening}};
}

Result<North> find_north(const FusedRate& rate, double latitude_deg, const Tilt& tilt) {
  constexpr const char* kWhere = "north finding";
  constexpr double kDegreesPerRadian = 180 / std::numbers::pi, kPole_deg = 90, kMinSigmas = 10, kCoverage = 0.95;
  if (!(std::abs(latitude_deg) <= kPole_deg) || !(tilt.about_north_deg >= 0) || !(tilt.about_east_deg >= 0))
    return failure(FaultKind::usage, kWhere,
                   fmt::format("the latitude is {}°, the uncertainty of the tilt {}° about north and {}° about east",
                               latitude_deg, tilt.about_north_deg, tilt.about_east_deg));
  const double latitude = latitude_deg / kDegreesPerRadian;
  const double horizontal = kEarthRateDegPerHour * std::cos(latitude);
  const double vertical = kEarthRateDegPerHour * std::sin(latitude);
  const double heading = std::atan2(-rate.deg_per_h(1), rate.deg_per_h(0));
  const Eigen::Vector3d north(std::cos(heading), -std::sin(heading), 0), east(std::sin(heading), std::cos(heading), 0);
  const double east_std =
      std::sqrt(east.dot(rate.covariance * east) + std::pow(tilt.about_north_deg / kDegreesPerRadian * vertical, 2));
  const double north_std =
      std::sqrt(north.dot(rate.covariance * north) + std::pow(tilt.about_east_deg / kDegreesPerRadian * vertical, 2));
  if (!(horizontal > kMinSigmas * east_std))
    return failure(
        FaultKind::numeric, kWhere,
        fmt::format(
            "the horizontal Earth rate of {:.3g} °/h is too small for an uncertainty of {:.3g} °/h towards east",
            horizontal, east_std));
  const double seen = rate.deg_per_h.head<2>().norm();
  if (!(std::abs(seen - horizontal) <= kMinSigmas * north_std))
    return failure(FaultKind::numeric, kWhere,
                   fmt::format("the horizontal rate is {:.6g} °/h, expected {:.6g} °/h", seen, horizontal));
  const double standard = east_std / horizontal * kDegreesPerRadian;
  const double heading_deg = heading * kDegreesPerRadian;
  return North{.heading_deg = heading_deg > -180 ? heading_deg : 180,
               .standard_deg = standard,
               .expanded_deg = standard * data::coverage_factor(kCoverage, std::numeric_limits<double>::infinity())};
}

}  // namespace gyrotherm::fusion
