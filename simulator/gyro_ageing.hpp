// SPDX-License-Identifier: Apache-2.0
/// Changes of a gyro and its thermometers between runs: coefficients age, thermometers drift from day to day, and the
/// block is stored warm and cold. The gyro's seed and the day determine all of them, so the state after 30 days lies on
/// the path to the state after one year.
#pragma once

#include <cstdint>

#include "simulator/gyro_bias.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Returns the seed of all values that each run draws independently. It differs between days.
[[nodiscard]] std::uint64_t noise_seed(LaboratorySeed seed);

/// Returns the drawn gyro aged by `seed.days_later` days. Each ageing coefficient is multiplied by 1 + its yearly
/// change · days/365. The random walk of each thermometer advances by one step a day. If drift_by_calendar is set, the
/// walk from the calibration to day 0 is added too and days_since_calibration becomes 0, so a run draws no drift of its
/// own. Otherwise the gyro of day 0 is unchanged.
[[nodiscard]] LaboratoryParameters age_gyro(LaboratoryParameters gyro, LaboratorySeed seed);

/// Returns the drift of each thermometer between two days after its calibration: a random walk with one step a day. A
/// gyro's walk does not depend on the requested range of days.
[[nodiscard]] EachThermometer calendar_drift_k(const EachThermometer& drift_k_per_sqrt_day, std::uint64_t gyro,
                                               std::uint64_t from_day, std::uint64_t to_day);

/// Returns the storage history of the gyro before its run on day `seed.days_later`, and the seed of that run. Each
/// turning point of the storage temperature is uniform between lowest and highest.
[[nodiscard]] GyroHistory make_history(const StorageTemperatures& storage, LaboratorySeed seed);

}  // namespace gyrotherm::simulator
