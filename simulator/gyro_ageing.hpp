// SPDX-License-Identifier: Apache-2.0
/// Changes of a gyro and its thermometers between runs: coefficients age, thermometers drift by the calendar, and the
/// block is stored warm and cold. The gyro's seed and the day determine all of them, so a run 30 days later lies on the
/// path to a run one year later.
#pragma once

#include <cstdint>

#include "simulator/gyro_bias.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Returns the seed of everything that each run draws independently. A run on another day is another run.
[[nodiscard]] std::uint64_t noise_seed(LaboratorySeed seed);

/// Returns the drawn gyro `seed.days_later` days older. Each ageing coefficient is multiplied by 1 + its yearly change
/// · days/365. The random walk of each thermometer advances by one step a day. If the thermometers drift by the
/// calendar, the walk up to day 0 belongs to the gyro and a run draws none of it; otherwise the gyro of day 0 is
/// unchanged.
[[nodiscard]] LaboratoryParameters aged(LaboratoryParameters gyro, LaboratorySeed seed);

/// Returns the drift of each thermometer between two days after its calibration: a random walk with one step a day. A
/// gyro's walk does not depend on the requested range of days.
[[nodiscard]] EachThermometer calendar_drift_k(const EachThermometer& drift_k_per_sqrt_day, std::uint64_t gyro,
                                               std::uint64_t from_day, std::uint64_t to_day);

/// Returns the storage history of the gyro before the run of that day, and the seed of the run. Each turning point of
/// the storage temperature is uniform between lowest and highest.
[[nodiscard]] GyroPast make_past(const Storage& storage, LaboratorySeed seed);

}  // namespace gyrotherm::simulator
