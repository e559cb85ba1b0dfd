// SPDX-License-Identifier: Apache-2.0
/// The attitude of the units under test in the chamber: the [fixture] of a rig file, and the Earth's rate along an
/// input axis. Values; any thread.
#pragma once

#include <array>
#include <optional>

#include "acquisition/record/run_info.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::rig {

/// A vector in fixture coordinates: x, y and z right-handed. If all three angles are zero, x points north, y west and z
/// up.
using FixtureVector = std::array<double, 3>;

/// A fixture's attitude in degrees, each angle with its standard uncertainty if the rig file states it.
struct Fixture {
  double latitude{};
  /// Direction of x, from true north towards east.
  double azimuth{};
  /// Angle of x above the horizontal.
  double elevation{};
  double roll{};  ///< about x, right-handed
  std::optional<double> latitude_uncertainty{}, azimuth_uncertainty{}, elevation_uncertainty{}, roll_uncertainty{};
};

/// Reads `latitude`, degrees, north positive. Records an error outside ±90.
[[nodiscard]] double read_latitude(const TomlTable& table);

inline constexpr double kQuarterTurn = 90, kFullTurn = 360;
/// Reads an angle in degrees; `usual` if the key is absent. Records an error outside ±`most`.
[[nodiscard]] double read_angle(const TomlTable& table, const char* key, double usual, double most);

/// Reads the standard uncertainty of an angle, 0 to 45 degrees; nothing if the key is absent.
[[nodiscard]] std::optional<double> read_angle_uncertainty(const TomlTable& table, const char* key);

/// Reads [fixture]: latitude, azimuth, elevation, roll and the uncertainty of each (`latitude_uncertainty` …).
[[nodiscard]] Fixture read_fixture(const TomlTable& table);

/// Reads a standard uncertainty of zero or more; nothing if the key is absent.
[[nodiscard]] std::optional<double> read_uncertainty(const TomlTable& table, const char* key);

/// Returns the component of the Earth's rate along an input axis: Ω (cos φ cos az cos el + sin φ sin el); az from true
/// north, el above the horizontal.
[[nodiscard]] DegreesPerHour earth_rate(double latitude_deg, double azimuth_deg, double elevation_deg);

/// Computes the attitude of an input axis along `direction` from the fixture, and stores it in `axis`: azimuth,
/// elevation and the Earth's rate, with the uncertainties of the fixture's latitude, azimuth, elevation and roll, and
/// of the axis' direction in the fixture (`direction_uncertainty`, degrees). The uncertainties stay separate, because
/// several fixture angles affect each angle of the axis. A budget multiplies each uncertainty by the corresponding
/// partial derivative of the Earth's rate.
void orient_axis(const Fixture& fixture, const FixtureVector& direction,
                 const std::optional<double>& direction_uncertainty, record::AxisInfo& axis);

}  // namespace gyrotherm::rig
