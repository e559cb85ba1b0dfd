// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/north.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/data/distributions.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::fusion {

Result<North> north_of(const FusedRate& rate, double latitude_deg, const Tilt& tilt) {
  constexpr const char* kWhere = "north finding";
  constexpr double kDegrees = 180 / std::numbers::pi, kPole_deg = 90, kEnough = 10, kCoverage = 0.95;
  if (!(std::abs(latitude_deg) <= kPole_deg) || !(tilt.about_north_deg >= 0) || !(tilt.about_east_deg >= 0))
    return failure(FaultKind::usage, kWhere,
                   fmt::format("a latitude of {}° and a tilt known to {}° about north and {}° about east", latitude_deg,
                               tilt.about_north_deg, tilt.about_east_deg));
  const double latitude = latitude_deg / kDegrees;
  const double horizontal = kEarthRateDegPerHour * std::cos(latitude);
  const double vertical = kEarthRateDegPerHour * std::sin(latitude);
  const double heading = std::atan2(-rate.deg_per_h(1), rate.deg_per_h(0));
  const Eigen::Vector3d north(std::cos(heading), -std::sin(heading), 0), east(std::sin(heading), std::cos(heading), 0);
  const double of_east =
      std::sqrt(east.dot(rate.covariance * east) + std::pow(tilt.about_north_deg / kDegrees * vertical, 2));
  const double of_north =
      std::sqrt(north.dot(rate.covariance * north) + std::pow(tilt.about_east_deg / kDegrees * vertical, 2));
  if (!(horizontal > kEnough * of_east))
    return failure(
        FaultKind::numeric, kWhere,
        fmt::format("the Earth turns by {:.3g} °/h about north, and east is known to {:.3g} °/h", horizontal, of_east));
  const double seen = rate.deg_per_h.head<2>().norm();
  if (!(std::abs(seen - horizontal) <= kEnough * of_north))
    return failure(FaultKind::numeric, kWhere,
                   fmt::format("{:.6g} °/h is seen about the horizontal, {:.6g} °/h expected", seen, horizontal));
  const double standard = of_east / horizontal * kDegrees;
  return North{.heading_deg = heading * kDegrees,
               .standard_deg = standard,
               .expanded_deg = standard * data::coverage_factor(kCoverage, std::numeric_limits<double>::infinity())};
}

}  // namespace gyrotherm::fusion
