/// What the gyro makes of its rotation: an accumulated angle with noise, counted in whole pulses, and a clock of its
/// own.
#pragma once

#include <cstdint>

#include "core/quantity.hpp"
#include "core/random.hpp"
#include "simulator/flicker.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm {

/// angle += rate + 60·N·white each second (1 °/h is 1 arcsec/s; N in °/√h), counted as floor(angle / arcsec_per_pulse).
/// The rate is bias + Earth rate + turn-on offset + what drifts: a first-order Markov process and bias instability
/// (flicker.hpp), both from their stationary distribution on, and a rate random walk (K in °/h/√h) from 0 on.
class GyroReadout {
 public:
  GyroReadout(const ReadoutParameters& parameters, std::uint64_t seed);

  /// Lets one second pass at this bias.
  void step(DegreesPerHour bias);

  [[nodiscard]] DegreesPerHour drift() const;  ///< all that is added to bias and Earth rate, for the second to come
  [[nodiscard]] std::int64_t pulses() const { return pulses_; }
  [[nodiscard]] std::int64_t device_time_us() const;
  [[nodiscard]] double arcsec_per_pulse() const { return parameters_.arcsec_per_pulse; }

 private:
  void wander();

  ReadoutParameters parameters_;
  RandomStream angle_noise_;
  RandomStream drift_noise_;
  RandomStream walk_noise_;
  Flicker instability_;
  double drift_memory_;  ///< of the Markov drift, per second
  double drift_deg_per_h_;
  double walk_deg_per_h_{};
  double turn_on_deg_per_h_;
  double angle_arcsec_{};
  std::int64_t pulses_{};
  std::int64_t seconds_{};
};

}  // namespace gyrotherm
