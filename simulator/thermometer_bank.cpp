// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermometer_bank.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/random.hpp"
#include "simulator/gyro_bias.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm::simulator {

namespace {

void scatter_bias(LumpedBias& bias, double sigma, RandomStream random) {
  for (double* coefficient : {&bias.linear_deg_per_h_per_k, &bias.quadratic_deg_per_h_per_k2, &bias.wave_deg_per_h,
                              &bias.arm_deg_per_h_per_k}) {
    *coefficient *= random.log_normal(sigma);
  }
  for (double& coefficient : bias.gradient_deg_per_h_per_k) coefficient *= random.log_normal(sigma);
}

void scatter_bias(BiasPhysics& bias, double sigma, RandomStream random) {
  for (double* coefficient : {&bias.flow.velocity_cm_per_s, &bias.flow.unbalance, &bias.linear_deg_per_h_per_k,
                              &bias.quadratic_deg_per_h_per_k2, &bias.mode_hops.step_deg_per_h}) {
    *coefficient *= random.log_normal(sigma);
  }
  for (double& coefficient : bias.mirror_deg_per_h_per_k) coefficient *= random.log_normal(sigma);
  for (auto& wave : bias.waves) {
    wave.deg_per_h *= random.log_normal(sigma);
    wave.phase_deg = 360 * random.uniform();
  }
  for (auto& play : bias.plays) play.deg_per_h *= random.log_normal(sigma);
}

void scatter_body(LumpedGyroParameters& gyro, const SpreadParameters& spread, std::uint64_t seed) {
  RandomStream capacity(seed, RandomPurpose::capacity_spread);
  RandomStream film(seed, RandomPurpose::film_spread);
  for (double& c : gyro.network.capacity_j_per_k) c *= capacity.log_normal(spread.capacity);
  for (double& g : gyro.network.film_w_per_k) g *= film.log_normal(spread.film);
}

void scatter_body(ReducedGyroParameters& gyro, const SpreadParameters& /*spread*/, std::uint64_t seed) {
  RandomStream random(seed, RandomPurpose::thermal_spread);
  RandomStream leads(seed, RandomPurpose::lead_spread);
  for (double* lead : {&gyro.arms.left_lead_w_per_k, &gyro.arms.right_lead_w_per_k})
    *lead *= leads.log_normal(gyro.lead_spread);
  // Apply the arms first: a changed heat capacity changes the basis in which a lead is given in watts per kelvin.
  gyro.model = perturb_model(apply_unequal_arms(std::move(gyro.model), gyro.arms), gyro.spread, random);
  gyro.arms = {};
}

void scatter_thermometers(ThermometerParameters& thermometers, const SpreadParameters& spread, std::uint64_t seed) {
  RandomStream offset(seed, RandomPurpose::thermometer_offset);
  RandomStream gain(seed, RandomPurpose::thermometer_gain);
  RandomStream time_constant(seed, RandomPurpose::thermometer_time_constant);
  for (double& error_k : thermometers.offset_k) error_k += spread.offset_k * offset.normal();
  for (double& error : thermometers.gain) error += spread.gain * gain.normal();
  for (double& lag_s : thermometers.time_constant_s) lag_s *= time_constant.log_normal(spread.time_constant);
}

void scatter_hard(ReducedGyroParameters& gyro, const HardSpread& spread, RandomStream& random) {
  const auto redraw = [&](double& amplitude) {
    amplitude *= random.log_normal(spread.amplitude) * (random.uniform() < 0.5 ? -1 : 1);
  };
  const auto draw_new = [&](double& value, double deviation) { value = deviation * random.normal(); };
  auto& bias = gyro.bias;
  for (double* gamma : {&bias.growth.gas_flow, &bias.growth.backscatter}) draw_new(*gamma, spread.growth);
  for (double& gamma : bias.growth.mirrors) draw_new(gamma, spread.growth);
  for (double* lag_s : {&bias.lags.gas_flow.time_constant_s, &bias.lags.deformation.time_constant_s})
    *lag_s = std::max(1.0, *lag_s * random.log_normal(spread.amplitude));
  redraw(bias.flow.unbalance_per_k);
  for (auto& term : bias.relaxations) redraw(term.deg_per_h_per_k);
  for (auto& phase : bias.warm_up) redraw(phase.deg_per_h);
  redraw(bias.mode_hops.transient_deg_per_h);
  if (bias.mode_hops.phase_modes) bias.mode_hops.phase_modes = random.uniform() - 0.5;
  draw_new(gyro.ageing.gas_flow, spread.ageing_per_year);
  for (double& per_year : gyro.ageing.mirrors) draw_new(per_year, spread.ageing_per_year);
  draw_new(gyro.ageing.gas_balance, spread.ageing_per_year);
}

void scatter_hard(LumpedGyroParameters& /*has nothing of it*/, const HardSpread& /*spread*/, RandomStream& /*random*/) {
}

/// Multiplies `amplitude` by a log-normal factor and draws its sign. Limits the result to −most … most.
void redraw(double& amplitude, double most, const HardSpread& spread, RandomStream& random) {
  amplitude *= random.log_normal(spread.amplitude) * (random.uniform() < 0.5 ? -1 : 1);
  amplitude = std::clamp(amplitude, -most, most);
}

/// Draws added heat from separate streams. The draws of all other parameters do not depend on it.
void scatter_heat(ReducedGyroParameters& gyro, const HardSpread& spread, std::uint64_t seed) {
  RandomStream winds(seed, RandomPurpose::side_wind);
  for (double* wind : {&gyro.wind.steady, &gyro.wind.heating, &gyro.wind.cooling})
    redraw(*wind, kMostWind, spread, winds);
  RandomStream growths(seed, RandomPurpose::power_growth);
  auto& growth = gyro.power_growth;
  for (double* per_k : {&growth.gain_per_k, &growth.preamplifier_per_k, &growth.ballast_per_k, &growth.split_per_k})
    redraw(*per_k, kMostPowerGrowthPerK, spread, growths);
}

void scatter_heat(LumpedGyroParameters& /*has nothing of it*/, const HardSpread& /*spread*/, std::uint64_t /*seed*/) {}

void scatter_hard(ReadoutParameters& readout, ThermometerParameters& thermometers, const HardSpread& spread,
                  RandomStream& random) {
  for (double* amplitude : {&readout.scale_factor_ppm, &readout.tilt_arcmin})
    *amplitude *= random.log_normal(spread.amplitude) * (random.uniform() < 0.5 ? -1 : 1);
  readout.walk_growth = std::min(kMostWalkGrowth, readout.walk_growth * random.log_normal(spread.amplitude));
  for (double& self_heating_k : thermometers.self_heating_k) self_heating_k *= random.log_normal(spread.amplitude);
}

}  // namespace

LaboratoryParameters draw_gyro(LaboratoryParameters type, std::uint64_t seed) {
  if (seed == 0) return type;
  const auto spread = type.spread;
  RandomStream turn_on(seed, RandomPurpose::turn_on);
  std::visit(
      [&](auto& body) {
        scatter_body(body, spread, seed);
        scatter_bias(body.bias, spread.bias, RandomStream(seed, RandomPurpose::bias_spread));
      },
      type.body);
  scatter_thermometers(type.thermometers, spread, seed);
  if (spread.hard) {
    RandomStream random(seed, RandomPurpose::hard_spread);
    std::visit([&](auto& body) { scatter_hard(body, *spread.hard, random); }, type.body);
    scatter_hard(type.gyro, type.thermometers, *spread.hard, random);
    std::visit([&](auto& body) { scatter_heat(body, *spread.hard, seed); }, type.body);
    RandomStream dead_band(seed, RandomPurpose::dead_band);
    type.gyro.dead_band.half_width_deg_per_h *= dead_band.log_normal(spread.hard->amplitude);
  }
  type.gyro.turn_on_deg_per_h += spread.turn_on_deg_per_h * turn_on.normal();
  return type;
}

namespace {

static_assert(std::tuple_size_v<EachThermometer> == kThermalLocations);
constexpr double kSecondsPerDay = 86400;
constexpr double kCalibratedAtC = 20;
constexpr double kPlatinumPerK = 3.9083e-3;  // IEC 60751

}  // namespace

double round_to_resolution(double value, double resolution) {
  return resolution > 0 ? std::round(value / resolution) * resolution : value;
}

ThermometerBank::ThermometerBank(const ThermometerParameters& parameters, LocationTemperatures locations_c,
                                 std::uint64_t seed)
    : parameters_(parameters),
      noise_(seed, RandomPurpose::thermometer_noise),
      drift_noise_(seed, RandomPurpose::thermometer_drift),
      spikes_(seed, RandomPurpose::thermometer_spikes) {
  const auto& p = parameters_;
  std::ranges::copy(locations_c, sensed_c_.begin());
  for (std::size_t i = 0; i < kThermalLocations; ++i) {
    follow_[i] = p.time_constant_s[i] > 0 ? closing_share(p.time_constant_s[i]) : 1;
    drift_per_sqrt_s_[i] = p.drift_k_per_sqrt_day[i] / std::sqrt(kSecondsPerDay);
    drifts_ = drifts_ || p.drift_k_per_sqrt_day[i] > 0;
    drift_k_[i] = p.drift_k_per_sqrt_day[i] * std::sqrt(p.days_since_calibration) * drift_noise_.normal();
  }
  read();
}

void ThermometerBank::step(LocationTemperatures locations_c) {
  for (std::size_t i = 0; i < kThermalLocations; ++i) sensed_c_[i] += follow_[i] * (locations_c[i] - sensed_c_[i]);
  if (drifts_) drift();
  ++seconds_;
  const auto before_c = readings_c_;
  read();
  fail(before_c);
}

void ThermometerBank::drift() {
  for (std::size_t i = 0; i < kThermalLocations; ++i) drift_k_[i] += drift_per_sqrt_s_[i] * drift_noise_.normal();
}

void ThermometerBank::read() {
  const auto& p = parameters_;
  for (std::size_t i = 0; i < kThermalLocations; ++i) {
    const double above_k = sensed_c_[i] - kCalibratedAtC;
    const double error_k =
        p.offset_k[i] + p.gain[i] * above_k + drift_k_[i] + p.self_heating_k[i] * (1 + kPlatinumPerK * above_k);
    const double shown_c = sensed_c_[i] + error_k + p.noise_k[i] * noise_.normal();
    readings_c_[i] = round_to_resolution(shown_c, p.resolution_k[i]);
  }
}

void ThermometerBank::fail(const std::array<double, kThermalLocations>& before_c) {
  for (const auto& failing : parameters_.failing) {
    if (seconds_ <= failing.from_s) continue;
    double& reading_c = readings_c_[failing.index];
    switch (failing.mode) {
      case FailureMode::stuck: reading_c = before_c[failing.index]; break;
      case FailureMode::dead: reading_c = std::numeric_limits<double>::quiet_NaN(); break;
      case FailureMode::offset: reading_c += failing.error_k; break;
      case FailureMode::spikes:
        if (spikes_.uniform() < failing.spikes_per_h / kSecondsPerHour)
          reading_c += spikes_.uniform() < 0.5 ? -failing.error_k : failing.error_k;
        break;
    }
  }
}

}  // namespace gyrotherm::simulator
