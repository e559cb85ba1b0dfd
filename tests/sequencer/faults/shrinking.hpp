// SPDX-License-Identifier: Apache-2.0
/// Makes a failing schedule as short as it can be and still fail.
#pragma once

#include "tests/sequencer/faults/simulated_run.hpp"

namespace gyrotherm::faults {

/// Mishaps in all of the profile's time, and a third more.
[[nodiscard]] ScheduleOptions options_for(const SimulatedSetup& ground);
/// Every second, every few, or in batches: as the seed says.
[[nodiscard]] std::int64_t sync_every(std::uint64_t seed);

/// The schedule of `setting`, which breaks a law, without the injected faults that the same law does not need to be
/// broken, and with the others as short as may be.
[[nodiscard]] Schedule reduced(const SimulatedSetup& ground, const SimulatedRunSetting& setting);

}  // namespace gyrotherm::faults
