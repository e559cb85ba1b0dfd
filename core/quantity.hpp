// SPDX-License-Identifier: Apache-2.0
/// Types for temperatures, temperature differences, rates and durations, and parsers for their notation. Two
/// temperatures cannot be added; a difference can be added to a temperature.
#pragma once

#include <chrono>
#include <compare>
#include <optional>
#include <span>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

using Duration = std::chrono::nanoseconds;

inline constexpr Duration kSecond = std::chrono::seconds(1);
inline constexpr double kSecondsPerMinute = 60;
inline constexpr double kSecondsPerHour = 3600;
inline constexpr double kZeroCelsiusInKelvin = 273.15;
inline constexpr double kEarthRateDegPerHour = 15.041067;  // 7.292115e-5 rad/s

[[nodiscard]] constexpr double to_seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
[[nodiscard]] constexpr Duration from_seconds(double s) {
  return std::chrono::round<Duration>(std::chrono::duration<double>(s));
}

/// A temperature difference, such as a band or a step.
struct Kelvins {
  double value{};
  auto operator<=>(const Kelvins&) const = default;
};
[[nodiscard]] constexpr Kelvins operator+(Kelvins a, Kelvins b) { return {a.value + b.value}; }
[[nodiscard]] constexpr Kelvins operator-(Kelvins a, Kelvins b) { return {a.value - b.value}; }
[[nodiscard]] constexpr Kelvins operator-(Kelvins a) { return {-a.value}; }
[[nodiscard]] constexpr Kelvins operator*(Kelvins a, double k) { return {a.value * k}; }
[[nodiscard]] constexpr Kelvins abs(Kelvins a) { return {a.value < 0 ? -a.value : a.value}; }

/// A temperature.
struct Celsius {
  double value{};
  auto operator<=>(const Celsius&) const = default;
};
[[nodiscard]] constexpr Kelvins operator-(Celsius a, Celsius b) { return {a.value - b.value}; }
[[nodiscard]] constexpr Celsius operator+(Celsius a, Kelvins b) { return {a.value + b.value}; }
[[nodiscard]] constexpr Celsius operator-(Celsius a, Kelvins b) { return {a.value - b.value}; }

/// A rate of temperature change. Positive means heating, unless the variable's contract calls it a magnitude.
struct CelsiusPerMinute {
  double value{};
  auto operator<=>(const CelsiusPerMinute&) const = default;
};
[[nodiscard]] constexpr Kelvins operator*(CelsiusPerMinute r, Duration d) { return {r.value * to_seconds(d) / 60.0}; }
[[nodiscard]] constexpr Duration operator/(Kelvins k, CelsiusPerMinute r) {
  return from_seconds(60.0 * k.value / r.value);
}

/// A rotation rate, and the unit of a gyro's bias. 1 °/h is exactly 1 arcsec/s.
struct DegreesPerHour {
  double value{};
  auto operator<=>(const DegreesPerHour&) const = default;
};
[[nodiscard]] constexpr DegreesPerHour operator+(DegreesPerHour a, DegreesPerHour b) { return {a.value + b.value}; }
[[nodiscard]] constexpr DegreesPerHour operator-(DegreesPerHour a, DegreesPerHour b) { return {a.value - b.value}; }
[[nodiscard]] constexpr DegreesPerHour operator*(DegreesPerHour a, double k) { return {a.value * k}; }

/// Parses a duration: "2 h", "90 s", "1 h 30 min", "250 ms". Fails with bad_file; the message contains the text.
[[nodiscard]] Result<Duration> parse_duration(std::string_view text);

/// Parses a number and its unit, as in "-40 °C", and returns the number. Returns nothing if the text has another form
/// or the unit is not one of `units`.
[[nodiscard]] std::optional<double> parse_quantity(std::string_view text, std::span<const std::string_view> units);

}  // namespace gyrotherm
