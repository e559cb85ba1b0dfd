// SPDX-License-Identifier: Apache-2.0
#include "rig/fixture.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/quantity.hpp"

namespace gyrotherm::rig {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
/// A slope of the Earth's rate so small, relative to Ω, that no tilt is told by it.
constexpr double kNoSlope = 1e-6;

using Vector = std::array<double, 3>;  ///< north, west, up

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// About the axis numbered `about`, right-handed.
Vector turned(const Vector& v, std::size_t about, double radians) {
  const std::size_t i = (about + 1) % 3, j = (about + 2) % 3;
  Vector result = v;
  result[i] = v[i] * std::cos(radians) - v[j] * std::sin(radians);
  result[j] = v[i] * std::sin(radians) + v[j] * std::cos(radians);
  return result;
}

Vector in_the_room(const Fixture& fixture, const FixtureVector& vector) {
  const auto rolled = turned(vector, 0, fixture.roll * kRadian);
  const auto raised = turned(rolled, 1, -fixture.elevation * kRadian);
  return turned(raised, 2, -fixture.azimuth * kRadian);
}

/// How the Earth's rate on `axis`, as a share of Ω, changes with a small turn about `about`, per degree.
double slope(const Vector& axis, const Vector& about, double latitude_deg) {
  const Vector earth{std::cos(latitude_deg * kRadian), 0, std::sin(latitude_deg * kRadian)};
  return kRadian * dot(earth, cross(about, axis));
}

/// Of a turn by 1° that may have any direction at right angles to the axis, the mean square's root.
double slope_of_any_turn(const Vector& axis, double latitude_deg) {
  const Vector earth{std::cos(latitude_deg * kRadian), 0, std::sin(latitude_deg * kRadian)};
  const auto across = cross(earth, axis);
  return kRadian * std::sqrt(dot(across, across) / 2);
}

}  // namespace

std::optional<double> read_uncertainty(const TomlTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  const double value = table.number(key);
  if (value >= 0 && std::isfinite(value)) return value;
  table.mistake(key, "expected a standard uncertainty, which is not below zero");
  return std::nullopt;
}

DegreesPerHour earth_rate(double latitude_deg, double azimuth_deg, double elevation_deg) {
  const double phi = latitude_deg * kRadian, az = azimuth_deg * kRadian, el = elevation_deg * kRadian;
  return {kEarthRateDegPerHour * (std::cos(phi) * std::cos(az) * std::cos(el) + std::sin(phi) * std::sin(el))};
}

double read_latitude(const TomlTable& table) {
  const double latitude = table.number("latitude");
  if (!(std::abs(latitude) <= 90))
    table.mistake("latitude", fmt::format("\"latitude\" is {:g}°, expected -90 to 90, north above 0", latitude));
  return latitude;
}

Fixture read_fixture(const TomlTable& table) {
  return {.latitude = read_latitude(table),
          .azimuth = table.number("azimuth", 0),
          .elevation = table.number("elevation", 0),
          .roll = table.number("roll", 0),
          .latitude_uncertainty = read_uncertainty(table, "latitude_uncertainty"),
          .azimuth_uncertainty = read_uncertainty(table, "azimuth_uncertainty"),
          .elevation_uncertainty = read_uncertainty(table, "elevation_uncertainty"),
          .roll_uncertainty = read_uncertainty(table, "roll_uncertainty")};
}

void place_axis(const Fixture& fixture, const FixtureVector& direction,
                const std::optional<double>& direction_uncertainty, record::AxisInfo& axis) {
  const auto points = in_the_room(fixture, direction);
  const double level = std::hypot(points[0], points[1]);
  const double azimuth = level > 0 ? std::atan2(-points[1], points[0]) / kRadian : 0;
  const double elevation = std::atan2(points[2], level) / kRadian;
  axis.direction = direction;
  axis.earth_rate = earth_rate(fixture.latitude, azimuth, elevation);
  auto& known = axis.uncertainty;
  known.latitude_deg = fixture.latitude;
  known.azimuth_deg = azimuth;
  known.elevation_deg = elevation;
  known.latitude_uncertainty_deg = fixture.latitude_uncertainty;
  known.azimuth_uncertainty_deg = fixture.azimuth_uncertainty;
  if (!fixture.elevation_uncertainty && !fixture.roll_uncertainty && !direction_uncertainty) return;
  // The fixture is raised about its own horizontal axis, which is west where its azimuth is zero.
  const auto about_west = turned({0, 1, 0}, 2, -fixture.azimuth * kRadian);
  const auto about_x = in_the_room(fixture, {1, 0, 0});
  const double by_elevation = slope(points, about_west, fixture.latitude) * fixture.elevation_uncertainty.value_or(0);
  const double by_roll = slope(points, about_x, fixture.latitude) * fixture.roll_uncertainty.value_or(0);
  const double by_direction = slope_of_any_turn(points, fixture.latitude) * direction_uncertainty.value_or(0);
  const double together = std::hypot(by_elevation, by_roll, by_direction);
  // What the budget multiplies it with: the Earth's rate by the elevation of the axis.
  const double phi = fixture.latitude * kRadian, az = azimuth * kRadian, el = elevation * kRadian;
  const double by_tilt = kRadian * std::abs(std::sin(phi) * std::cos(el) - std::cos(phi) * std::cos(az) * std::sin(el));
  known.tilt_uncertainty_deg = by_tilt > kNoSlope * kRadian ? together / by_tilt
                                                            : std::hypot(fixture.elevation_uncertainty.value_or(0),
                                                                         fixture.roll_uncertainty.value_or(0),
                                                                         direction_uncertainty.value_or(0));
}

}  // namespace gyrotherm::rig
