// SPDX-License-Identifier: Apache-2.0
/// Interprets the names of columns in files of other programs.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::exchange {

/// Returns the text with its ASCII letters in lower case. Names of channels are compared in this form.
[[nodiscard]] std::string in_lower_case(std::string_view text);

/// Returns whether a name looks like the name of a temperature: "Temp", "T3", "die [°C]", "sensor_baro.temperature".
[[nodiscard]] bool is_temperature_name(std::string_view name);
/// Returns whether a name looks like the name of a gyro's rate or increment: "gyro x", "Gx", "wz [deg/h]",
/// "sensor_combined.gyro_rad[0]", or has the unit of a rate: "rate_dph", "Kreisel °/h". Returns false for filter
/// estimates, for integrals, and for the times and counts of integrals.
[[nodiscard]] bool is_gyro_name(std::string_view name);
/// Returns whether a name looks like the name of a time.
[[nodiscard]] bool is_time_name(std::string_view name);

// Units in names. A name has its unit in brackets at its end, "T [K]", or after a "_", a "." or a blank, "gyro_x_dps".
// The whole unit must match: "mdps" does not match "dps".

/// Finds the unit of a rate in a name and returns its size in °/h: "deg/h", "rad/s", "mdps", "0.01 deg/s", "arcsec/s".
/// Returns nothing if the name has no known unit.
[[nodiscard]] std::optional<double> degrees_per_hour_in(std::string_view name);
/// Returns the unit of a temperature in a name: "°C", "K" or "°F", however the name spells it, or the text in brackets
/// if it is an unknown unit. Returns an empty text if the name has no unit.
[[nodiscard]] std::string temperature_unit_in(std::string_view name);

/// Converts a number to °C: number × scale + offset.
struct CelsiusScale {
  double scale = 1, offset = 0;
};
/// Returns the scale of a temperature unit with an optional prefix or factor: "°C", "mK", "0.01 °C", "°F". Returns
/// nothing for an unknown unit.
[[nodiscard]] std::optional<CelsiusScale> celsius_scale(std::string_view unit);

/// Returns the unit of a time in a name: "s", "ms", "us", "ns", "min", "h" or "d", however the name spells it, or the
/// text in brackets if it is an unknown unit. Returns an empty text if the name has no unit.
[[nodiscard]] std::string time_unit_in(std::string_view name);
/// Returns the axis at the end of a name: "x", "y" or "z"; empty if there is none.
[[nodiscard]] std::string axis_in(std::string_view name);

/// Returns a permitted channel name for a column. Removes the unit, replaces Latin letters with accents ("e" for "é",
/// "ae" for "ä"), and removes characters that are not allowed.
[[nodiscard]] std::string channel_name_for(std::string_view column);

/// Returns true if a column of that name has increments since the row before: "pulses", "dtheta_x".
[[nodiscard]] bool is_increment_name(std::string_view name);

/// Returns the columns of the gyro. If some names contain "gyr", returns only those columns. If the names contain
/// message names, returns only columns of the first message that has any.
[[nodiscard]] std::vector<std::size_t> gyro_columns(const std::vector<std::string>& names);

}  // namespace gyrotherm::exchange
