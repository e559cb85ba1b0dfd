// SPDX-License-Identifier: Apache-2.0
/// Numbers that carry their physical meaning (points, amounts and rates), and how people write them.
/// A point of temperature cannot be added to another; an amount can.
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

/// An amount of temperature: a difference, a band, a step.
struct Kelvins {
  double value{};
  auto operator<=>(const Kelvins&) const = default;
};
[[nodiscard]] constexpr Kelvins operator+(Kelvins a, Kelvins b) { return {a.value + b.value}; }
[[nodiscard]] constexpr Kelvins operator-(Kelvins a, Kelvins b) { return {a.value - b.value}; }
[[nodiscard]] constexpr Kelvins operator-(Kelvins a) { return {-a.value}; }
[[nodiscard]] constexpr Kelvins operator*(Kelvins a, double k) { return {a.value * k}; }
[[nodiscard]] constexpr Kelvins abs(Kelvins a) { return {a.value < 0 ? -a.value : a.value}; }

/// A point on the Celsius scale.
struct Celsius {
  double value{};
  auto operator<=>(const Celsius&) const = default;
};
[[nodiscard]] constexpr Kelvins operator-(Celsius a, Celsius b) { return {a.value - b.value}; }
[[nodiscard]] constexpr Celsius operator+(Celsius a, Kelvins b) { return {a.value + b.value}; }
[[nodiscard]] constexpr Celsius operator-(Celsius a, Kelvins b) { return {a.value - b.value}; }

/// A rate of temperature change; positive heats, unless a place says that it holds a magnitude.
struct CelsiusPerMinute {
  double value{};
  auto operator<=>(const CelsiusPerMinute&) const = default;
};
[[nodiscard]] constexpr Kelvins operator*(CelsiusPerMinute r, Duration d) { return {r.value * to_seconds(d) / 60.0}; }
[[nodiscard]] constexpr Duration operator/(Kelvins k, CelsiusPerMinute r) {
  return from_seconds(60.0 * k.value / r.value);
}

/// A rate of rotation, and the unit of a gyro's bias. 1 °/h is 1 arcsec/s exactly.
struct DegreesPerHour {
  double value{};
  auto operator<=>(const DegreesPerHour&) const = default;
};
[[nodiscard]] constexpr DegreesPerHour operator+(DegreesPerHour a, DegreesPerHour b) { return {a.value + b.value}; }
[[nodiscard]] constexpr DegreesPerHour operator-(DegreesPerHour a, DegreesPerHour b) { return {a.value - b.value}; }
[[nodiscard]] constexpr DegreesPerHour operator*(DegreesPerHour a, double k) { return {a.value * k}; }

/// Reads a duration: "2 h", "90 s", "1 h 30 min", "250 ms". Fails with bad_file, naming the text.
[[nodiscard]] Result<Duration> parse_duration(std::string_view text);

/// The number that stands before one of `units`, as in "-40 °C"; nothing if the text is anything else.
[[nodiscard]] std::optional<double> quantity_in(std::string_view text, std::span<const std::string_view> units);

}  // namespace gyrotherm
