// SPDX-License-Identifier: Apache-2.0
/// Shortens a failing schedule as far as it still fails.
#pragma once

#include "tests/sequencer/faults/simulated_run.hpp"

namespace gyrotherm::faults {

/// Returns options for faults during the planned duration of the profile plus one third.
[[nodiscard]] ScheduleOptions options_for(const SimulatedSetup& ground);
/// Returns the interval of syncs that the seed draws: every second, every few, or in batches.
[[nodiscard]] std::int64_t sync_every(std::uint64_t seed);

/// Reduces the schedule of `setting`, which violates an invariant: removes the faults that the violation does not need,
/// and shortens the others as far as possible.
[[nodiscard]] Schedule shrink_schedule(const SimulatedSetup& ground, const SimulatedRunSetting& setting);

}  // namespace gyrotherm::faults
