// SPDX-License-Identifier: Apache-2.0
/// Shortens a failing schedule as far as it still fails.
#pragma once

#include "tests/sequencer/faults/simulated_run.hpp"

namespace gyrotherm::faults {

/// Returns options for faults during the planned duration of the profile plus one third.
[[nodiscard]] ScheduleOptions options_for(const SimulatedSetup& ground);
/// Draws the sync interval for a seed: each second, every few seconds, or a batch.
[[nodiscard]] std::int64_t sync_every(std::uint64_t seed);

/// Shrinks the schedule of `setting`, which violates an invariant. Removes the faults without which the violation still
/// occurs, and shortens the others as far as possible.
[[nodiscard]] Schedule shrink_schedule(const SimulatedSetup& ground, const SimulatedRunSetting& setting);

}  // namespace gyrotherm::faults
