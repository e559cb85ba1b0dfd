// SPDX-License-Identifier: Apache-2.0
/// The inputs of the checks of one second, and the checks that measurements are plausible: noise changes the readings,
/// a gyro at rest measures the Earth's rate, thermometers respond, and no thermometer jumps or drifts away from the
/// others. Pure; any thread. Used inside sequencer/interlocks only.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sequencer/interlocks/interlocks.hpp"

namespace gyrotherm::interlocks {

/// The inputs of one second. The trends in `memory` include this sample. The watches in `memory`, and
/// `chamber_answered`, still describe the previous second.
struct CheckInputs {
  const InterlockLimits& limits;
  const InterlockMemory& memory;
  const Sample& sample;
  const InterlockInputs& facts;
  Ranks ranks;

  [[nodiscard]] const ChamberState* chamber() const { return sample.chamber.value ? &*sample.chamber.value : nullptr; }
  /// Returns true if the cause was present one second ago.
  [[nodiscard]] bool was_found(InterlockId id) const { return memory.is_cause_present(id); }
  [[nodiscard]] bool is_dropped(std::size_t unit) const { return unit < facts.dropped.size() && facts.dropped[unit]; }
  [[nodiscard]] bool continues_without(std::size_t unit) const {
    return unit < limits.units.size() && limits.units[unit].continue_when_silent;
  }
  [[nodiscard]] std::string unit(std::size_t unit) const {
    return unit < limits.units.size() ? limits.units[unit].name : std::to_string(unit + 1);
  }
  /// Returns true if a unit that is not dropped needs the thermometer.
  [[nodiscard]] bool is_needed(std::size_t column) const {
    for (std::size_t i = 0; i < limits.units.size(); ++i)
      if (!is_dropped(i) && std::ranges::count(limits.units[i].thermometers, column) > 0) return true;
    return false;
  }
  [[nodiscard]] std::string channel(std::size_t column) const {
    return column < limits.channels.size() ? "thermometer " + limits.channels[column] : "a thermometer";
  }
  [[nodiscard]] bool is_frozen(std::size_t column) const {
    return interlocks::is_frozen(limits, memory.liveness, column);
  }
  [[nodiscard]] bool is_dead(std::size_t unit) const {
    const auto& units = memory.liveness.units;
    return unit < units.size() && std::ranges::any_of(units[unit], &AxisLiveness::is_dead);
  }
  /// Returns the subject of this thermometer's alarms.
  [[nodiscard]] std::string subject(std::size_t column) const {
    return column < limits.channels.size() ? limits.channels[column] : std::to_string(column + 1);
  }
  [[nodiscard]] CheckResult thermometer_result(std::size_t column, std::string text) const {
    return {.text = std::move(text), .column = column, .subject = subject(column)};
  }
};

/// Returns a result if the air has left the range that the set points explain (ExplainedAir), in the first minutes of a
/// run. The result is grave if the air is far outside.
[[nodiscard]] std::vector<CheckResult> find_unexplained_air(const CheckInputs& in);

/// Finds instruments, and the chamber's air, with identical readings for longer than their noise allows.
[[nodiscard]] std::vector<CheckResult> find_frozen_instruments(const CheckInputs& in);

/// Finds dead axes: no counts although the Earth's rate requires some, identical counts for longer than the noise
/// permits, or a rate far from the Earth's rate.
[[nodiscard]] std::vector<CheckResult> find_dead_axes(const CheckInputs& in);

/// Returns a result if the air or the set point has moved by response_step and no thermometer has moved in response.
[[nodiscard]] std::vector<CheckResult> find_missing_response(const CheckInputs& in);

/// Finds thermometers that jumped, for example because two were exchanged, and thermometers that change while the
/// others are at rest.
[[nodiscard]] std::vector<CheckResult> find_drifting_thermometers(const CheckInputs& in);

/// Returns a result if the coldest thermometer of the units is not warmer than the dew point of the chamber's air, or
/// its frost point below 0 °C, by condensation_margin.
[[nodiscard]] std::vector<CheckResult> find_condensation(const CheckInputs& in);

/// Returns a result if the door may be opened, or is open, while the unit is colder than the dew point of the air that
/// would enter.
[[nodiscard]] std::vector<CheckResult> find_cold_unit_at_door(const CheckInputs& in);

}  // namespace gyrotherm::interlocks
