// SPDX-License-Identifier: Apache-2.0
/// Draws the parameters of one gyro of a type. All gyros of a type have the same body and bias model.
#pragma once

#include <array>
#include <cstdint>

#include "core/random.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm::simulator {

/// Returns the gyro of a seed. Seed 0 is exactly the gyro of the file. For any other seed each bias coefficient is
/// multiplied by its own log-normal factor and phases are drawn; each thermometer receives a calibration error and
/// another time constant, and the gyro a constant offset. The heat capacities and films of the reference simulation are
/// multiplied in the same way; a reduced model is perturbed (simulator/thermal/reduced/reduced_model.hpp). Parameters
/// that only a hard rig has are drawn with their own spread from a separate stream.
[[nodiscard]] LaboratoryParameters draw_gyro(LaboratoryParameters type, std::uint64_t seed);

// The virtual thermometers: true temperatures → readings with lag, calibration error, drift, noise and resolution.

/// Returns `value` rounded to the nearest multiple of `resolution`. A resolution of 0 returns it unchanged.
[[nodiscard]] double round_to_resolution(double value, double resolution);

/// The thermometers. Each follows the temperature of its location with a first-order lag and reads, rounded to its
/// resolution, T + offset + gain·(T − 20 °C) + drift + self-heating + white noise. The drift is a random walk that
/// started at the calibration. Self-heating grows with the resistance of platinum (IEC 60751: 0.39 % per kelvin). A
/// failing thermometer reads a wrong value from its failure time on; a dead one reads NaN.
class ThermometerBank {
 public:
  /// Starts in equilibrium with `locations_c` and reads it once.
  ThermometerBank(const ThermometerParameters& parameters, LocationTemperatures locations_c, std::uint64_t seed);

  /// Advances by one second: each sensor follows the temperature of its location, then all are read.
  void step(LocationTemperatures locations_c);

  [[nodiscard]] LocationTemperatures readings_c() const { return readings_c_; }

 private:
  void drift();
  void read();
  void fail(const std::array<double, kThermalLocations>& before_c);

  ThermometerParameters parameters_;
  RandomStream noise_;
  RandomStream drift_noise_;
  RandomStream spikes_;
  double seconds_{};
  /// Fraction of its difference from the location that each thermometer closes in one second.
  EachThermometer follow_{};
  EachThermometer drift_per_sqrt_s_{};  ///< K
  bool drifts_ = false;
  EachThermometer drift_k_{};
  std::array<double, kThermalLocations> sensed_c_{};
  std::array<double, kThermalLocations> readings_c_{};
};

}  // namespace gyrotherm::simulator
