// SPDX-License-Identifier: Apache-2.0
#include "simulator/gyro_ageing.hpp"

#include <cmath>

#include "core/random.hpp"

namespace gyrotherm::simulator {
namespace {

void age(BiasPhysics& bias, const Ageing& ageing, double days) {
  constexpr double kDaysPerYear = 365;
  const auto change = [&](double& coefficient, double per_year) { coefficient *= 1 + per_year * days / kDaysPerYear; };
  change(bias.flow.velocity_cm_per_s, ageing.gas_flow);
  change(bias.flow.unbalance, ageing.gas_balance);
  for (std::size_t i = 0; i < ageing.mirrors.size(); ++i) change(bias.mirror_deg_per_h_per_k[i], ageing.mirrors[i]);
}

}  // namespace

std::uint64_t noise_seed(LaboratorySeed seed) {
  const auto day_0_seed = splitmix64(seed.gyro ^ splitmix64(seed.run));
  return seed.days_later == 0 ? day_0_seed : splitmix64(day_0_seed ^ splitmix64(seed.days_later));
}

EachThermometer calendar_drift_k(const EachThermometer& drift_k_per_sqrt_day, std::uint64_t gyro,
                                 std::uint64_t from_day, std::uint64_t to_day) {
  RandomStream steps(gyro, RandomPurpose::thermometer_calendar);
  EachThermometer drift_k{};
  for (std::uint64_t day = 0; day < to_day; ++day)
    for (std::size_t i = 0; i < drift_k.size(); ++i) {
      const double step_k = drift_k_per_sqrt_day[i] * steps.normal();
      if (day >= from_day) drift_k[i] += step_k;
    }
  return drift_k;
}

LaboratoryParameters age_gyro(LaboratoryParameters gyro, LaboratorySeed seed) {
  auto& thermometers = gyro.thermometers;
  const auto day_0 = static_cast<std::uint64_t>(std::llround(thermometers.days_since_calibration));
  const auto first = thermometers.drift_by_calendar ? 0 : day_0;
  const auto drift_k = calendar_drift_k(thermometers.drift_k_per_sqrt_day, seed.gyro, first, day_0 + seed.days_later);
  for (std::size_t i = 0; i < drift_k.size(); ++i) thermometers.offset_k[i] += drift_k[i];
  if (thermometers.drift_by_calendar) thermometers.days_since_calibration = 0;
  if (auto* body = std::get_if<ReducedGyroParameters>(&gyro.body))
    age(body->bias, body->ageing, static_cast<double>(seed.days_later));
  return gyro;
}

GyroHistory make_history(const StorageTemperatures& storage, LaboratorySeed seed) {
  GyroHistory past{.turning_points_c = {}, .run = noise_seed(seed)};
  if (storage.turns == 0) return past;
  RandomStream turns(seed.gyro, RandomPurpose::storage);
  const auto count = static_cast<std::uint64_t>(storage.turns) + seed.days_later;
  for (std::uint64_t i = 0; i < count; ++i)
    past.turning_points_c.push_back(storage.lowest_c + (storage.highest_c - storage.lowest_c) * turns.uniform());
  return past;
}

LaboratoryParameters soak_at(LaboratoryParameters parameters, Celsius first) {
  parameters.plant.start_c = first.value;
  if (auto* reduced = std::get_if<ReducedGyroParameters>(&parameters.body)) reduced->start_c = first.value;
  if (auto* lumped = std::get_if<LumpedGyroParameters>(&parameters.body)) lumped->network.start_c = first.value;
  return parameters;
}

}  // namespace gyrotherm::simulator
