// SPDX-License-Identifier: Apache-2.0
/// What the name of a foreign column suggests that it is.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::exchange {

/// The text with its ASCII letters small, as names of channels are compared.
[[nodiscard]] std::string in_lower_case(std::string_view text);

/// Whether a name sounds like that of a temperature: "Temp", "T3", "die [°C]", "sensor_baro.temperature".
[[nodiscard]] bool is_temperature_name(std::string_view name);
/// … of a gyro's rate or increment: "gyro x", "Gx", "wz [deg/h]", "sensor_combined.gyro_rad[0]"; not of what a filter
/// estimates of it, of integrals, their times and counts.
[[nodiscard]] bool is_gyro_name(std::string_view name);
/// … of a time.
[[nodiscard]] bool is_time_name(std::string_view name);

// A name says its unit in brackets at its end, "T [K]", or behind a "_", a "." or a blank, "gyro_x_dps". The
// whole of it counts: "mdps" is no "dps".

/// The unit of a rate in its name, as °/h per unit: "deg/h", "rad/s", "mdps", "0.01 deg/s", "arcsec/s"; nothing if it
/// says none that is known.
[[nodiscard]] std::optional<double> degrees_per_hour_in(std::string_view name);
/// The unit of a temperature in its name: "°C", "K" and "°F" however they are written, another one in brackets as it
/// stands there; empty if it says none.
[[nodiscard]] std::string temperature_unit_in(std::string_view name);

/// Converts a number to °C: number × scale + offset.
struct CelsiusScale {
  double scale = 1, offset = 0;
};
/// Returns the scale of a temperature unit with an optional prefix or factor: "°C", "mK", "0.01 °C", "°F". Nothing for
/// an unknown unit.
[[nodiscard]] std::optional<CelsiusScale> celsius_scale_of(std::string_view unit);

/// The unit of a time in its name: "s", "ms", "us", "ns", "min", "h", "d" however they are written, another one in
/// brackets as it stands there; empty if it says none.
[[nodiscard]] std::string time_unit_in(std::string_view name);
/// The axis that a name ends in: "x", "y", "z"; empty if it says none.
[[nodiscard]] std::string axis_in(std::string_view name);

/// A name that a channel may have, made of a column's: without its unit and what may not stand in a name.
[[nodiscard]] std::string channel_name_of(std::string_view column);

/// Returns true if numbers of that name are increments since the row before: "pulses", "dtheta_x".
[[nodiscard]] bool is_increment_name(std::string_view name);

/// The columns of the gyro: those that sound so, and say it where any does; of the first message that has any where the
/// names are of messages.
[[nodiscard]] std::vector<std::size_t> gyro_columns(const std::vector<std::string>& names);

}  // namespace gyrotherm::exchange
