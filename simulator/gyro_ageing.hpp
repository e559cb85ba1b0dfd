// SPDX-License-Identifier: Apache-2.0
/// What happens to a gyro and its thermometers between runs: coefficients age, thermometers drift by the calendar, the
/// block is stored warm and cold. All of it is determined by the gyro's seed and the day, so that a run 30 days later
/// lies on the way to one a year later.
#pragma once

#include <cstdint>

#include "simulator/gyro_bias.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Draws what each run draws anew; another day is another run.
[[nodiscard]] std::uint64_t noise_seed(LaboratorySeed seed);

/// The drawn gyro, `seed.days_later` days older: each coefficient that ages times 1 + its yearly change · days/365;
/// each thermometer's walk so many steps of a day further. Where the thermometers drift by the calendar the walk up to
/// day 0 is the gyro's as well, and a run draws none of it. On day 0 the others are as they were given.
[[nodiscard]] LaboratoryParameters aged(LaboratoryParameters gyro, LaboratorySeed seed);

/// Drift of each thermometer from one day after its calibration to another: a random walk with a step a day, the same
/// for a gyro whatever part of it is asked for.
[[nodiscard]] EachThermometer calendar_drift_k(const EachThermometer& drift_k_per_sqrt_day, std::uint64_t gyro,
                                               std::uint64_t from_day, std::uint64_t to_day);

/// Where the gyro was before the run of that day, and what draws the run. Each turn of its storage is uniform between
/// lowest and highest.
[[nodiscard]] GyroPast past_of(const Storage& storage, LaboratorySeed seed);

}  // namespace gyrotherm::simulator
