// SPDX-License-Identifier: Apache-2.0
/// Checks that a measurement behaves like one: it changes as a noisy reading does, a gyro at rest turns with the Earth,
/// thermometers respond, and none jumps or drifts away from the others. Pure; any thread.
#pragma once

#include <vector>

#include "sequencer/interlocks/check_inputs.hpp"

namespace gyrotherm::interlocks {

/// Finds instruments, and the chamber's air, that have been identical to the last digit for longer than their noise
/// allows.
[[nodiscard]] std::vector<CheckResult> frozen(const CheckInputs& in);

/// Finds axes that count nothing where the Earth's rate is known, whose counts are identical for longer than their
/// noise allows, or whose rate is far from the Earth's.
[[nodiscard]] std::vector<CheckResult> gyro_dead(const CheckInputs& in);

/// Finds that the air or the set point has moved by response_step and no thermometer has followed.
[[nodiscard]] std::vector<CheckResult> no_thermal_response(const CheckInputs& in);

/// Finds thermometers that jumped, as two that were exchanged do, and those that move while everything else is at rest.
[[nodiscard]] std::vector<CheckResult> drifting(const CheckInputs& in);

}  // namespace gyrotherm::interlocks
