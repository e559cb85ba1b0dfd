// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/placed_readings.hpp"

#include <fmt/format.h>

#include <utility>

namespace gyrotherm::drivers {

Fault at_instrument(const std::string& place, Fault fault) {
  fault.where = fault.where.empty() ? place : fmt::format("{} {}", place, fault.where);
  return fault;
}

std::vector<Result<Celsius>> readings_at(const std::string& place, std::size_t inputs,
                                         Result<std::vector<Result<Celsius>>> answer) {
  if (!answer) return {inputs, failure(at_instrument(place, std::move(answer.error())))};
  for (auto& reading : *answer)
    if (!reading) reading.error() = at_instrument(place, std::move(reading.error()));
  return std::move(*answer);
}

}  // namespace gyrotherm::drivers
