// SPDX-License-Identifier: Apache-2.0
#include "simulator/gyro_bias.hpp"

#include <cmath>
#include <numbers>

#include "core/quantity.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr double kReferenceC = 20;

double at(InnerTemperatures inner_c, thermal::ThermalOutput output) {
  return inner_c[static_cast<std::size_t>(output)];
}

/// B, C, F, H.
std::array<double, 4> mirrors_c(InnerTemperatures inner_c) {
  return {at(inner_c, thermal::ThermalOutput::mirror_b), at(inner_c, thermal::ThermalOutput::mirror_c),
          at(inner_c, thermal::ThermalOutput::mirror_f), at(inner_c, thermal::ThermalOutput::mirror_h)};
}

/// What the light's path has grown by follows this: the mean of block and mirrors, half each.
double light_path_c(InnerTemperatures inner_c) {
  const auto mirrors = mirrors_c(inner_c);
  const double mirror_mean = (mirrors[0] + mirrors[1] + mirrors[2] + mirrors[3]) / 4;
  return (at(inner_c, thermal::ThermalOutput::block) + mirror_mean) / 2;
}

double hysteresis_deg_per_h(const std::vector<HysteresisPlay>& worth, const std::vector<Play>& plays) {
  double sum = 0;
  for (std::size_t i = 0; i < plays.size(); ++i) sum += worth[i].deg_per_h * plays[i].lag_k() / worth[i].half_width_k;
  return sum;
}

}  // namespace

double gas_flow_deg_per_h(const GasFlow& flow, double left_c, double right_c) {
  const auto velocity = [&](double arm_c) {
    return flow.velocity_cm_per_s *
           std::pow((arm_c + kZeroCelsiusInKelvin) / (kReferenceC + kZeroCelsiusInKelvin), flow.exponent);
  };
  const double half = flow.unbalance / 2;
  return flow.shift_deg_per_h_per_cm_per_s * ((1 + half) * velocity(left_c) - (1 - half) * velocity(right_c));
}

double deformation_deg_per_h(const BiasPhysics& physics, InnerTemperatures inner_c) {
  const auto mirrors = mirrors_c(inner_c);
  const double block = at(inner_c, thermal::ThermalOutput::block);
  double sum = 0;
  for (std::size_t i = 0; i < mirrors.size(); ++i) sum += physics.mirror_deg_per_h_per_k[i] * (mirrors[i] - block);
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

GyroBias::GyroBias(const BiasPhysics& physics, InnerTemperatures start_c)
    : physics_(physics), lock_(physics.mode_hops, light_path_c(start_c)) {
  for (const auto& play : physics.plays)
    plays_.emplace_back(play.half_width_k, at(start_c, thermal::ThermalOutput::block));
  step(start_c);
}

void GyroBias::step(InnerTemperatures now_c) {
  const double block = at(now_c, thermal::ThermalOutput::block);
  const double path = light_path_c(now_c);
  for (auto& play : plays_) play.follow(block);
  lock_.follow(path);
  parts_ = {.gas_flow = gas_flow_deg_per_h(physics_.flow, at(now_c, thermal::ThermalOutput::gain_left),
                                           at(now_c, thermal::ThermalOutput::gain_right)),
            .deformation = deformation_deg_per_h(physics_, now_c),
            .temperature = temperature_deg_per_h(physics_, block),
            .backscatter = backscatter_deg_per_h(physics_.waves, path),
            .hysteresis = hysteresis_deg_per_h(physics_.plays, plays_),
            .mode_hops = physics_.mode_hops.step_deg_per_h * lock_.mode()};
}

DegreesPerHour GyroBias::total() const {
  const auto& p = parts_;
  return {p.gas_flow + p.deformation + p.temperature + p.backscatter + p.hysteresis + p.mode_hops};
}

}  // namespace gyrotherm::simulator
