// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/fixture.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/quantity.hpp"

namespace gyrotherm::rig {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
using Vector = std::array<double, 3>;  ///< north, west, up

/// Rotates a vector about the axis numbered `about`, right-handed.
Vector rotate(const Vector& v, std::size_t about, double radians) {
  const std::size_t i = (about + 1) % 3, j = (about + 2) % 3;
  Vector result = v;
  result[i] = v[i] * std::cos(radians) - v[j] * std::sin(radians);
  result[j] = v[i] * std::sin(radians) + v[j] * std::cos(radians);
  return result;
}

Vector to_north_west_up(const Fixture& fixture, const FixtureVector& vector) {
  const auto rolled = rotate(vector, 0, fixture.roll * kRadian);
  const auto raised = rotate(rolled, 1, -fixture.elevation * kRadian);
  return rotate(raised, 2, -fixture.azimuth * kRadian);
}

}  // namespace

std::optional<double> read_uncertainty(const TomlTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  const double value = table.number(key);
  if (value >= 0 && std::isfinite(value)) return value;
  table.note_error(key, "expected a standard uncertainty of zero or more");
  return std::nullopt;
}

double read_angle(const TomlTable& table, const char* key, double usual, double most) {
  const double angle = table.number(key, usual);
  if (!(std::abs(angle) <= most))
    table.note_error(key, fmt::format("\"{}\" is {:g}°, expected {:g} to {:g}", key, angle, -most, most));
  return angle;
}

std::optional<double> read_angle_uncertainty(const TomlTable& table, const char* key) {
  constexpr double kMost = 45;
  const auto value = read_uncertainty(table, key);
  if (value && *value > kMost)
    table.note_error(key, fmt::format("\"{}\" is {:g}°, expected at most {:g}", key, *value, kMost));
  return value;
}

DegreesPerHour earth_rate(double latitude_deg, double azimuth_deg, double elevation_deg) {
  const double phi = latitude_deg * kRadian, az = azimuth_deg * kRadian, el = elevation_deg * kRadian;
  return {kEarthRateDegPerHour * (std::cos(phi) * std::cos(az) * std::cos(el) + std::sin(phi) * std::sin(el))};
}

double read_latitude(const TomlTable& table) {
  const double latitude = table.number("latitude");
  if (!(std::abs(latitude) <= kQuarterTurn))
    table.note_error("latitude", fmt::format("\"latitude\" is {:g}°, expected -90 to 90, north positive", latitude));
  return latitude;
}

Fixture read_fixture(const TomlTable& table) {
  return {.latitude = read_latitude(table),
          .azimuth = read_angle(table, "azimuth", 0, kFullTurn),
          .elevation = read_angle(table, "elevation", 0, kQuarterTurn),
          .roll = read_angle(table, "roll", 0, kFullTurn),
          .latitude_uncertainty = read_angle_uncertainty(table, "latitude_uncertainty"),
          .azimuth_uncertainty = read_angle_uncertainty(table, "azimuth_uncertainty"),
          .elevation_uncertainty = read_angle_uncertainty(table, "elevation_uncertainty"),
          .roll_uncertainty = read_angle_uncertainty(table, "roll_uncertainty")};
}

void orient_axis(const Fixture& fixture, const FixtureVector& direction,
                 const std::optional<double>& direction_uncertainty, record::AxisInfo& axis) {
  const auto points = to_north_west_up(fixture, direction);
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
  known.fixture_azimuth_deg = fixture.azimuth;
  known.fixture_elevation_deg = fixture.elevation;
  known.elevation_uncertainty_deg = fixture.elevation_uncertainty;
  known.roll_uncertainty_deg = fixture.roll_uncertainty;
  known.direction_uncertainty_deg = direction_uncertainty;
}

}  // namespace gyrotherm::rig
