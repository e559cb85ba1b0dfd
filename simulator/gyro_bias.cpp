// SPDX-License-Identifier: Apache-2.0
#include "simulator/gyro_bias.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/quantity.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr double kReferenceC = 20;

double at(InnerTemperatures inner_c, thermal::ThermalOutput output) {
  return inner_c[static_cast<std::size_t>(output)];
}

/// Returns the temperatures of mirrors B, C, F and H.
std::array<double, 4> mirrors_c(InnerTemperatures inner_c) {
  return {at(inner_c, thermal::ThermalOutput::mirror_b), at(inner_c, thermal::ThermalOutput::mirror_c),
          at(inner_c, thermal::ThermalOutput::mirror_f), at(inner_c, thermal::ThermalOutput::mirror_h)};
}

/// Returns the temperature that determines the length of the light's path: the mean of the block's temperature and the
/// mirrors' mean temperature.
double light_path_c(InnerTemperatures inner_c) {
  const auto mirrors = mirrors_c(inner_c);
  const double mirror_mean = (mirrors[0] + mirrors[1] + mirrors[2] + mirrors[3]) / 4;
  return (at(inner_c, thermal::ThermalOutput::block) + mirror_mean) / 2;
}

double velocity(const GasFlow& flow, double arm_c) {
  return flow.velocity_cm_per_s *
         std::pow((arm_c + kZeroCelsiusInKelvin) / (kReferenceC + kZeroCelsiusInKelvin), flow.exponent);
}

/// Returns 1 + γ (T̄ − 20 °C)/40 K.
double growth_factor(double growth, double block_c) {
  constexpr double kScaleK = 40;
  return 1 + growth * (block_c - kReferenceC) / kScaleK;
}

double hysteresis_deg_per_h(const std::vector<HysteresisPlay>& worth, const std::vector<Play>& plays) {
  double sum = 0;
  for (std::size_t i = 0; i < plays.size(); ++i) sum += worth[i].deg_per_h * plays[i].lag_k() / worth[i].half_width_k;
  return sum;
}

}  // namespace

double gas_flow_deg_per_h(const GasFlow& flow, double left_c, double right_c) {
  const double half = flow.unbalance / 2;
  return flow.shift_deg_per_h_per_cm_per_s *
         ((1 + half) * velocity(flow, left_c) - (1 - half) * velocity(flow, right_c));
}

double electronics_deg_per_h(const GasFlow& flow, InnerTemperatures inner_c) {
  const double mean = (velocity(flow, at(inner_c, thermal::ThermalOutput::gain_left)) +
                       velocity(flow, at(inner_c, thermal::ThermalOutput::gain_right))) /
                      2;
  const double warm_k = at(inner_c, thermal::ThermalOutput::preamplifier) - kReferenceC;
  return flow.shift_deg_per_h_per_cm_per_s * mean * flow.unbalance_per_k * warm_k;
}

double deformation_deg_per_h(const BiasPhysics& physics, InnerTemperatures inner_c) {
  const auto mirrors = mirrors_c(inner_c);
  const double block = at(inner_c, thermal::ThermalOutput::block);
  double sum = 0;
  for (std::size_t i = 0; i < mirrors.size(); ++i)
    sum += physics.mirror_deg_per_h_per_k[i] * growth_factor(physics.growth.mirrors[i], block) * (mirrors[i] - block);
  return sum;
}

double temperature_deg_per_h(const BiasPhysics& physics, double block_c) {
  const double x = block_c - kReferenceC;
  return physics.linear_deg_per_h_per_k * x + physics.quadratic_deg_per_h_per_k2 * x * x;
}

double backscatter_deg_per_h(const std::vector<BackscatterWave>& waves, double path_c) {
  double sum = 0;
  for (const auto& wave : waves) {
    const double turns = (path_c - kReferenceC) / wave.period_k + wave.phase_deg / 360;
    sum += wave.deg_per_h * std::sin(2 * std::numbers::pi * turns);
  }
  return sum;
}

ModeLock::ModeLock(const ModeHops& hops, double start_c, RandomStream random)
    : hops_(hops), zero_c_(hops.phase_modes ? kReferenceC : start_c), random_(random) {
  if (hops_.kelvin_per_mode == 0) return;
  mode_ = std::round((start_c - zero_c_) / hops_.kelvin_per_mode + hops_.phase_modes.value_or(0));
  before_ = mode_;
}

void ModeLock::follow(double path_c) {
  if (hops_.kelvin_per_mode == 0) return;
  ++passed_s_;
  const double wanted = (path_c - zero_c_) / hops_.kelvin_per_mode + hops_.phase_modes.value_or(0);
  if (std::abs(wanted - mode_) <= hops_.reach_modes) return;
  before_ = path_mode();
  mode_ = std::round(wanted);
  passed_s_ = 0;
  transient_s_ = hops_.shortest_s + (hops_.longest_s - hops_.shortest_s) * random_.uniform();
}

double ModeLock::remaining_share() const { return is_hopping() ? 1 - passed_s_ / transient_s_ : 0; }

double ModeLock::path_mode() const { return mode_ - remaining_share() * (mode_ - before_); }

double ModeLock::deg_per_h() const {
  return hops_.step_deg_per_h * path_mode() + hops_.transient_deg_per_h * remaining_share();
}

double closing_share(double time_constant_s) { return -std::expm1(-1 / time_constant_s); }

LaggingPart::LaggingPart(const HiddenLag& lag) : lag_(lag), closing_share_(closing_share(lag.time_constant_s)) {}

double LaggingPart::follow(double now) {
  if (!std::exchange(began_, true)) lagged_ = now;
  lagged_ += closing_share_ * (now - lagged_);
  return now + lag_.share * (lagged_ - now);
}

RelaxingBias::RelaxingBias(const std::vector<Relaxation>& terms, double start_c) {
  for (const auto& term : terms) terms_.push_back({term.deg_per_h_per_k, closing_share(term.time_constant_s), start_c});
}

void RelaxingBias::follow(double now_c) {
  deg_per_h_ = 0;
  for (auto& term : terms_) {
    term.relaxed_c += term.closing_share * (now_c - term.relaxed_c);
    deg_per_h_ += term.deg_per_h_per_k * (now_c - term.relaxed_c);
  }
}

double warm_up_deg_per_h(const std::vector<WarmUp>& phases, double seconds_on) {
  double sum = 0;
  for (const auto& phase : phases) sum += phase.deg_per_h * std::exp(-seconds_on / phase.time_constant_s);
  return sum;
}

GyroBias::GyroBias(const BiasPhysics& physics, InnerTemperatures start_c, const GyroHistory& past)
    : physics_(physics),
      lock_(physics.mode_hops, light_path_c(start_c), RandomStream(past.run, RandomPurpose::mode_hops)),
      flow_(physics.lags.gas_flow),
      deformation_(physics.lags.deformation),
      relaxing_(physics.relaxations, at(start_c, thermal::ThermalOutput::block)) {
  const double block = at(start_c, thermal::ThermalOutput::block);
  for (const auto& play : physics.plays) {
    plays_.emplace_back(play.half_width_k, past.turning_points_c.empty() ? block : past.turning_points_c.front());
    for (const double turned_c : past.turning_points_c) plays_.back().follow(turned_c);
  }
  follow(start_c);
}

void GyroBias::step(InnerTemperatures now_c) {
  ++seconds_on_;
  follow(now_c);
}

void GyroBias::follow(InnerTemperatures now_c) {
  const double block = at(now_c, thermal::ThermalOutput::block);
  const double path = light_path_c(now_c);
  for (auto& play : plays_) play.follow(block);
  lock_.follow(path);
  relaxing_.follow(block);
  const double flow = gas_flow_deg_per_h(physics_.flow, at(now_c, thermal::ThermalOutput::gain_left),
                                         at(now_c, thermal::ThermalOutput::gain_right));
  parts_ = {
      .gas_flow = flow_.follow(growth_factor(physics_.growth.gas_flow, block) * flow),
      .deformation = deformation_.follow(deformation_deg_per_h(physics_, now_c)),
      .temperature = temperature_deg_per_h(physics_, block),
      .backscatter = growth_factor(physics_.growth.backscatter, block) * backscatter_deg_per_h(physics_.waves, path),
      .hysteresis = hysteresis_deg_per_h(physics_.plays, plays_),
      .mode_hops = lock_.deg_per_h(),
      .electronics = electronics_deg_per_h(physics_.flow, now_c),
      .relaxation = relaxing_.deg_per_h(),
      .warm_up = warm_up_deg_per_h(physics_.warm_up, seconds_on_)};
}

DegreesPerHour GyroBias::total() const {
  const auto& p = parts_;
  return {p.gas_flow + p.deformation + p.temperature + p.backscatter + p.hysteresis + p.mode_hops + p.electronics +
          p.relaxation + p.warm_up};
}

}  // namespace gyrotherm::simulator
