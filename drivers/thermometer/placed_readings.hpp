// SPDX-License-Identifier: Apache-2.0
/// What a sensor can report; a reading outside it is a fault, whatever the instrument says.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::drivers {

struct TemperatureRange {
  Celsius lowest, highest;
  auto operator<=>(const TemperatureRange&) const = default;
};

/// `reading` itself, or out_of_range at `where`; a reading that is not a number is outside every range.
[[nodiscard]] inline Result<Celsius> within(const TemperatureRange& range, Celsius reading, std::string where) {
  if (reading >= range.lowest && reading <= range.highest) return reading;
  return failure(
      FaultKind::out_of_range, std::move(where),
      fmt::format("{} °C cannot be, expected {} to {} °C", reading.value, range.lowest.value, range.highest.value));
}

// An instrument's own place in front of its faults.

/// "thermometer 2 input 3": the place of the instrument, then that within it.
[[nodiscard]] Fault at_instrument(const std::string& place, Fault fault);

/// The readings with their faults so placed; if there is no answer, its fault for each of the `inputs`.
[[nodiscard]] std::vector<Result<Celsius>> readings_at(const std::string& place, std::size_t inputs,
                                                       Result<std::vector<Result<Celsius>>> answer);

}  // namespace gyrotherm::drivers
