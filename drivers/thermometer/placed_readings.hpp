// SPDX-License-Identifier: Apache-2.0
/// Helpers for the readings of thermometers: parsing, range checks, and the location of the instrument in faults.
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::drivers {

struct TemperatureRange {
  Celsius lowest, highest;
  auto operator<=>(const TemperatureRange&) const = default;
};

/// Returns `reading`, or the fault out_of_range at `where` if it is outside `range`. NaN is outside every range.
[[nodiscard]] inline Result<Celsius> check_range(const TemperatureRange& range, Celsius reading, std::string where) {
  if (reading >= range.lowest && reading <= range.highest) return reading;
  return failure(FaultKind::out_of_range, std::move(where),
                 fmt::format("{} °C is an impossible reading, expected {} to {} °C", reading.value, range.lowest.value,
                             range.highest.value));
}

/// Parses a sign followed by digits, with or without a point. Returns nothing for any other text.
[[nodiscard]] inline std::optional<double> parse_signed_decimal(std::string_view text) {
  if (text.size() < 2 || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const auto digits = text.substr(1);
  if (digits.find_first_not_of("0123456789.") != std::string_view::npos) return std::nullopt;
  double value{};
  const auto* const last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value, std::chars_format::fixed);
  if (error != std::errc{} || end != last) return std::nullopt;
  return text[0] == '-' ? -value : value;
}

/// Prepends the location of the instrument to the location of a fault: "thermometer 2 input 3".
[[nodiscard]] inline Fault add_location(const std::string& place, Fault fault) {
  fault.where = fault.where.empty() ? place : fmt::format("{} {}", place, fault.where);
  return fault;
}

/// Returns the readings in `answer`, with `place` prepended to the locations of their faults. If `answer` is itself a
/// fault, returns this fault for each of the `inputs`.
[[nodiscard]] inline std::vector<Result<Celsius>> add_locations(const std::string& place, std::size_t inputs,
                                                                Result<std::vector<Result<Celsius>>> answer) {
  if (!answer) return {inputs, failure(add_location(place, std::move(answer.error())))};
  for (auto& reading : *answer)
    if (!reading) reading.error() = add_location(place, std::move(reading.error()));
  return std::move(*answer);
}

}  // namespace gyrotherm::drivers
