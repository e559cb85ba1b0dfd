// SPDX-License-Identifier: Apache-2.0
/// How the units under test stand in the chamber: the [fixture] of a rig file, and the Earth's rate on an input axis
/// that is given in it. Values; any thread.
#pragma once

#include <array>
#include <optional>

#include "acquisition/record/run_info.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::rig {

/// A vector of the fixture's own: x, y and z right-handed. With all three angles zero x points north, y west and z up.
using FixtureVector = std::array<double, 3>;

/// A fixture's attitude in degrees, each angle with its standard uncertainty where the rig file says one.
struct Fixture {
  double latitude{};
  double azimuth{};    ///< of x, from true north over east
  double elevation{};  ///< of x, above the horizontal
  double roll{};       ///< about x, right-handed
  std::optional<double> latitude_uncertainty{}, azimuth_uncertainty{}, elevation_uncertainty{}, roll_uncertainty{};
};

/// Reads `latitude`, degrees, north above 0; beyond ±90 it is a mistake.
[[nodiscard]] double read_latitude(const TomlTable& table);

/// Reads [fixture]: latitude, azimuth, elevation, roll and the uncertainty of each (`latitude_uncertainty` …).
[[nodiscard]] Fixture read_fixture(const TomlTable& table);

/// A standard uncertainty, not below zero; nothing without the key.
[[nodiscard]] std::optional<double> read_uncertainty(const TomlTable& table, const char* key);

/// Ω on an input axis: Ω (cos φ cos az cos el + sin φ sin el); az from true north, el above the horizontal.
[[nodiscard]] DegreesPerHour earth_rate(double latitude_deg, double azimuth_deg, double elevation_deg);

/// Puts what the fixture's attitude says of an input axis along `direction` into `axis`: its azimuth and elevation, the
/// Earth's rate on it, and how well the fixture's latitude, azimuth, elevation and roll are known, and where the axis
/// lies in it (`direction_uncertainty`, degrees): each as it was said, for no angle of one axis can stand for two of a
/// fixture. A budget takes each by its own slope of the Earth's rate.
void place_axis(const Fixture& fixture, const FixtureVector& direction,
                const std::optional<double>& direction_uncertainty, record::AxisInfo& axis);

}  // namespace gyrotherm::rig
