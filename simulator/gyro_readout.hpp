// SPDX-License-Identifier: Apache-2.0
/// What the gyro makes of its rotation: an accumulated angle with noise, counted in whole pulses, and a clock of its
/// own.
#pragma once

#include <cstdint>
#include <vector>

#include "core/quantity.hpp"
#include "core/random.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm::simulator {

/// A stationary first-order Markov (Ornstein-Uhlenbeck) process.
struct MarkovProcess {
  double sigma{};
  double correlation_time_s{};
};

/// Processes, two a decade, whose spectra add up to flicker noise of level `instability` = B from frequency
/// 1/(2π longest_s) to 1/(2π shortest_s): two-sided S(f) = B²/(2πf), Allan deviation B √(2 ln 2/π) between (IEEE Std
/// 952, annex C). Equal variances at times spaced evenly on a logarithmic scale give that: ∫ 2σ²τ/(1 + (2πfτ)²) d ln τ
/// = σ²/(2f), so σ² = B²/π per unit of ln τ. Asserts 0 < shortest_s ≤ longest_s.
[[nodiscard]] std::vector<MarkovProcess> flicker_processes(double instability, double shortest_s, double longest_s);

/// The sum of such processes, once a second.
class Flicker {
 public:
  /// Starts from the stationary distribution.
  Flicker(const std::vector<MarkovProcess>& processes, RandomStream random);

  void step();
  [[nodiscard]] double value() const { return sum_; }

 private:
  struct Part {
    double memory;  ///< per second
    double fresh;
    double value;
  };
  std::vector<Part> parts_;
  RandomStream random_;
  double sum_{};
};

/// Half-width of the dead band with the block here: the file's at −40 °C, and 0 from where the dither does not sag.
[[nodiscard]] double half_width_deg_per_h(const DeadBand& band, Celsius block);

/// What a gyro tells of a rate Ω while it locks in below `half_width` = Ω_L: 0 up to there, sign(Ω) √(Ω² − Ω_L²)
/// beyond, the mean beat of two oscillators that pull each other (Adler, Proc. IRE 34, 1946; of the laser gyro
/// Aronowitz, Laser Applications 1, 1971). Far beyond Ω_L² / 2Ω is missing.
[[nodiscard]] DegreesPerHour locked(DegreesPerHour rate, double half_width_deg_per_h);

/// angle += rate + 60·N·white each second (1 °/h is 1 arcsec/s; N in °/√h), counted as floor(angle / arcsec_per_pulse).
/// The rate is bias + Earth rate + turn-on offset + what drifts: a first-order Markov process and bias instability
/// (Flicker), both from their stationary distribution on, and a rate random walk (K in °/h/√h) from 0 on.
/// A hard gyro's read-out depends on the block's temperature, by x = (T̄ − 20 °C)/40 K: N grows by 1 − g x · 40/60 (the
/// residual of lock-in), the rate by the scale factor's 1 + s x, and by Ω_crosswise sin(t x) where the axis tilts by t.
/// Where the dither sags only what is above the residual lock-in is told of the rate (locked).
class GyroReadout {
 public:
  GyroReadout(const ReadoutParameters& parameters, std::uint64_t seed);

  /// Lets one second pass at this bias and this temperature of the block; turned around, it sees −Ω.
  void step(DegreesPerHour bias, Celsius block = {20}, bool turned = false);
  /// Switched on again: draws another turn-on offset.
  void start_anew() { turn_on_deg_per_h_ = turn_on(); }

  [[nodiscard]] DegreesPerHour drift() const;  ///< all that is added to bias and Earth rate, for the second to come
  [[nodiscard]] std::int64_t pulses() const { return pulses_; }
  [[nodiscard]] std::int64_t device_time_us() const;
  [[nodiscard]] double arcsec_per_pulse() const { return parameters_.arcsec_per_pulse; }

 private:
  [[nodiscard]] bool loses_a_pulse();
  void wander();
  [[nodiscard]] double turn_on();

  ReadoutParameters parameters_;
  RandomStream angle_noise_;
  RandomStream drift_noise_;
  RandomStream walk_noise_;
  RandomStream losses_;
  RandomStream turn_ons_;
  Flicker instability_;
  double drift_memory_;  ///< of the Markov drift, per second
  double drift_deg_per_h_;
  double walk_deg_per_h_{};
  double turn_on_deg_per_h_;
  double angle_arcsec_{};
  std::int64_t pulses_{};
  std::int64_t seconds_{};
};

}  // namespace gyrotherm::simulator
