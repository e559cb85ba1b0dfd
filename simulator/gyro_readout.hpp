/// What the gyro makes of its rotation: an accumulated angle with noise, counted in whole pulses, and a clock of its
/// own.
#pragma once

#include <cstdint>

#include "core/quantity.hpp"
#include "simulator/random.hpp"
#include "simulator/world_parameters.hpp"

namespace gyrotherm {

/// angle += rate + 60·N·white each second (1 °/h is 1 arcsec/s; N in °/√h), counted as floor(angle / arcsec_per_pulse).
/// The rate is bias + Earth rate + turn-on offset + a first-order Markov drift that starts from its stationary
/// distribution.
class GyroReadout {
 public:
  GyroReadout(const ReadoutParameters& parameters, std::uint64_t seed);

  /// Lets one second pass at this bias.
  void step(DegreesPerHour thermal_bias);

  [[nodiscard]] DegreesPerHour drift() const;  ///< Markov drift and turn-on offset, for the second to come
  [[nodiscard]] std::int64_t pulses() const { return pulses_; }
  [[nodiscard]] std::int64_t device_time_us() const;

 private:
  ReadoutParameters parameters_;
  RandomStream angle_noise_;
  RandomStream drift_noise_;
  double drift_memory_;  ///< of the Markov drift, per second
  double drift_deg_per_h_;
  double angle_arcsec_{};
  std::int64_t pulses_{};
  std::int64_t seconds_{};
};

}  // namespace gyrotherm
