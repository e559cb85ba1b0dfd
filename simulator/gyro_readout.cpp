// SPDX-License-Identifier: Apache-2.0
#include "simulator/gyro_readout.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace gyrotherm::simulator {
namespace {

constexpr double kRadPerArcmin = std::numbers::pi / 180 / 60;

}  // namespace

std::vector<MarkovProcess> flicker_processes(double instability, double shortest_s, double longest_s) {
  assert(0 < shortest_s && shortest_s <= longest_s);
  if (instability == 0) return {};
  constexpr double kPerDecade = 2;
  const double sigma = instability * std::sqrt(std::numbers::ln10 / kPerDecade / std::numbers::pi);
  const auto steps = static_cast<int>(std::lround(kPerDecade * std::log10(longest_s / shortest_s)));
  std::vector<MarkovProcess> processes;
  for (int i = 0; i <= steps; ++i) processes.push_back({sigma, shortest_s * std::pow(10, i / kPerDecade)});
  return processes;
}

Flicker::Flicker(const std::vector<MarkovProcess>& processes, RandomStream random) : random_(random) {
  for (const auto& process : processes) {
    const double memory = std::exp(-1 / process.correlation_time_s);
    const double fresh = process.sigma * std::sqrt(1 - memory * memory);
    parts_.push_back({memory, fresh, process.sigma * random_.normal()});
    sum_ += parts_.back().value;
  }
}

void Flicker::step() {
  sum_ = 0;
  for (auto& part : parts_) {
    part.value = part.memory * part.value + part.fresh * random_.normal();
    sum_ += part.value;
  }
}

double half_width_deg_per_h(const DeadBand& band, Celsius block) {
  if (band.half_width_deg_per_h == 0) return 0;
  return band.half_width_deg_per_h * std::max(0.0, (band.sags_below_c - block.value) / (band.sags_below_c - kColdC));
}

DegreesPerHour apply_lock_in(DegreesPerHour rate, double half_width_deg_per_h) {
  if (half_width_deg_per_h == 0) return rate;
  const double beat = rate.value * rate.value - half_width_deg_per_h * half_width_deg_per_h;
  return {beat > 0 ? std::copysign(std::sqrt(beat), rate.value) : 0};
}

GyroReadout::GyroReadout(const ReadoutParameters& parameters, std::uint64_t seed)
    : parameters_(parameters),
      angle_noise_(seed, RandomPurpose::angle_noise),
      drift_noise_(seed, RandomPurpose::drift),
      walk_noise_(seed, RandomPurpose::rate_random_walk),
      losses_(seed, RandomPurpose::lost_pulses),
      turn_ons_(seed, RandomPurpose::turn_on_repeatability),
      instability_(flicker_processes(parameters.instability_deg_per_h, parameters.instability_from_s,
                                     parameters.instability_to_s),
                   RandomStream(seed, RandomPurpose::bias_instability)),
      drift_memory_(std::exp(-1 / parameters.drift_time_s)),
      drift_deg_per_h_(parameters.drift_deg_per_h * drift_noise_.normal()),
      turn_on_deg_per_h_(turn_on()) {}

double GyroReadout::turn_on() {
  return parameters_.turn_on_deg_per_h + parameters_.turn_on_repeatability_deg_per_h * turn_ons_.normal();
}

bool GyroReadout::draw_pulse_loss() {
  return parameters_.lost_pulses_per_h > 0 && losses_.uniform() < parameters_.lost_pulses_per_h / kSecondsPerHour;
}

void GyroReadout::step(DegreesPerHour bias, Celsius block, bool turned) {
  const auto& p = parameters_;
  const double warm = (block.value - 20) / 40;
  const double walk = 1 - p.walk_growth * warm * 40 / 60;
  const double scale = 1 + p.scale_factor_ppm * 1e-6 * warm;
  const double tilted = p.crosswise_earth_rate_deg_per_h * std::sin(p.tilt_arcmin * kRadPerArcmin * warm);
  const DegreesPerHour earth{turned ? -p.earth_rate_deg_per_h : p.earth_rate_deg_per_h};
  const DegreesPerHour rate = apply_lock_in(bias + drift() + earth, half_width_deg_per_h(p.dead_band, block));
  angle_arcsec_ += rate.value * scale + tilted + 60 * p.angle_random_walk_deg_per_sqrt_h * angle_noise_.normal() * walk;
  if (draw_pulse_loss()) angle_arcsec_ -= std::copysign(p.arcsec_per_pulse, rate.value);
  pulses_ = static_cast<std::int64_t>(std::floor(angle_arcsec_ / p.arcsec_per_pulse));
  ++seconds_;
  advance_drift();
}

void GyroReadout::advance_drift() {
  const double fresh = parameters_.drift_deg_per_h * std::sqrt(1 - drift_memory_ * drift_memory_);
  drift_deg_per_h_ = drift_memory_ * drift_deg_per_h_ + fresh * drift_noise_.normal();
  instability_.step();
  // The coefficient is per √h, the step one second.
  constexpr double kPerSqrtSecond = 1.0 / 60;
  walk_deg_per_h_ += parameters_.rate_random_walk_deg_per_h_per_sqrt_h * kPerSqrtSecond * walk_noise_.normal();
}

DegreesPerHour GyroReadout::drift() const {
  return {drift_deg_per_h_ + instability_.value() + walk_deg_per_h_ + turn_on_deg_per_h_};
}

std::int64_t GyroReadout::device_time_us() const {
  return std::llround(static_cast<double>(seconds_) * (1e6 + parameters_.clock_skew_ppm));
}

}  // namespace gyrotherm::simulator
