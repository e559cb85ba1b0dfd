// SPDX-License-Identifier: Apache-2.0
/// The gyro's read-out of its rotation: an accumulated angle with noise, counted in whole pulses, and the gyro's clock.
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

/// Returns processes, two per decade, whose spectra add up to flicker noise of level `instability` = B from frequency
/// 1/(2π longest_s) to 1/(2π shortest_s): two-sided S(f) = B²/(2πf), Allan deviation B √(2 ln 2/π) in between (IEEE Std
/// 952, annex C). Equal variances at times spaced evenly on a logarithmic scale yield this spectrum: ∫ 2σ²τ/(1 +
/// (2πfτ)²) d ln τ = σ²/(2f), so σ² = B²/π per unit of ln τ. Asserts 0 < shortest_s ≤ longest_s.
[[nodiscard]] std::vector<MarkovProcess> flicker_processes(double instability, double shortest_s, double longest_s);

/// A sum of Markov processes, advanced once a second.
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

/// Returns the half-width of the dead band at this block temperature: the file's value at −40 °C, falling linearly to 0
/// at the temperature below which the dither sags.
[[nodiscard]] double half_width_deg_per_h(const DeadBand& band, Celsius block);

/// Returns the rate that a gyro shows at the true rate Ω when it locks in below `half_width` = Ω_L: 0 for |Ω| up to
/// Ω_L, otherwise sign(Ω) √(Ω² − Ω_L²). This is the mean beat of two coupled oscillators (Adler, Proc. IRE 34, 1946;
/// for the laser gyro Aronowitz, Laser Applications 1, 1971). If |Ω| is much larger than Ω_L, the loss is Ω_L² / 2Ω.
[[nodiscard]] DegreesPerHour apply_lock_in(DegreesPerHour rate, double half_width_deg_per_h);

/// Simulates the read-out of a gyro. Each second, step() adds
///
///     rate · (1 + s x) + Ω_crosswise sin(t x) + 60 N (1 − g x · 40/60) · white
///
/// to the angle in arcsec (1 °/h is 1 arcsec/s; N in °/√h) and sets the pulses to floor(angle / arcsec_per_pulse). The
/// terms:
/// - rate: the sum of bias, Earth rate and drift(), after the loss by lock-in where the dither sags (apply_lock_in()).
/// - drift(): the sum of the turn-on offset, a first-order Markov process, bias instability (Flicker) and a rate random
///   walk (K in °/h/√h). The random walk starts at 0, the other two processes start in their stationary distribution.
/// - x = (T̄ − 20 °C)/40 K, with the block's temperature T̄. x matters only for a gyro with the parameters s, t or g.
/// - s = scale_factor_ppm · 1e-6: change of the scale factor.
/// - t = tilt_arcmin in radians: tilt of the input axis towards Ω_crosswise, the Earth rate perpendicular to it.
/// - g = walk_growth: growth of the angle random walk, because lock-in remains after dither.
/// - white: a standard normal number.
class GyroReadout {
 public:
  GyroReadout(const ReadoutParameters& parameters, std::uint64_t seed);

  /// Advances by one second at this bias and block temperature. A turned gyro measures −Ω.
  void step(DegreesPerHour bias, Celsius block = {20}, bool turned = false);
  /// Draws another turn-on offset: the gyro is switched on again.
  void restart() { turn_on_deg_per_h_ = turn_on(); }

  /// Returns the sum of all terms that are added to bias and Earth rate in the next second.
  [[nodiscard]] DegreesPerHour drift() const;
  [[nodiscard]] std::int64_t pulses() const { return pulses_; }
  [[nodiscard]] std::int64_t device_time_us() const;
  [[nodiscard]] double arcsec_per_pulse() const { return parameters_.arcsec_per_pulse; }

 private:
  [[nodiscard]] bool draw_pulse_loss();
  void advance_drift();
  [[nodiscard]] double turn_on();

  ReadoutParameters parameters_;
  RandomStream angle_noise_;
  RandomStream drift_noise_;
  RandomStream walk_noise_;
  RandomStream losses_;
  RandomStream turn_ons_;
  Flicker instability_;
  /// Factor by which the Markov drift decays in one second.
  double drift_memory_;
  double drift_deg_per_h_;
  double walk_deg_per_h_{};
  double turn_on_deg_per_h_;
  double angle_arcsec_{};
  std::int64_t pulses_{};
  std::int64_t seconds_{};
};

}  // namespace gyrotherm::simulator
