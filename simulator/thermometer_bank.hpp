// SPDX-License-Identifier: Apache-2.0
/// Draws one gyro of a type: the same body and the same bias law with other numbers.
#pragma once

#include <array>
#include <cstdint>

#include "core/random.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm::simulator {

/// Seed 0 is the gyro of the file exactly. Any other seed draws another: each bias coefficient is multiplied by a
/// log-normal factor of its own, and phases are drawn anew; every thermometer gets a calibration error and another time
/// constant, the gyro a constant offset. The reference simulation's heat capacities and films are multiplied likewise,
/// a twin's model is perturbed (simulator/thermal/reduced/reduced_model.hpp). What only a hard rig has is drawn by its
/// own spread, from a stream of its own.
[[nodiscard]] LaboratoryParameters draw_gyro(LaboratoryParameters type, std::uint64_t seed);

// The virtual thermometers: true temperatures → readings with lag, calibration error, drift, noise and resolution.

/// `value` to the nearest multiple of `resolution` (0: as it is).
[[nodiscard]] double to_resolution(double value, double resolution);

/// Each thermometer follows its place with a first-order lag and reads, to its resolution,
/// T + offset + gain·(T − 20 °C) + drift + self-heating + white noise. The drift is a random walk that began at the
/// calibration; self-heating grows as the resistance of platinum (IEC 60751: 0.39 % a kelvin). One that fails reads
/// something else from its time on; a dead one, NaN.
class ThermometerBank {
 public:
  /// Starts in equilibrium with `places_c` and reads it once.
  ThermometerBank(const ThermometerParameters& parameters, PlaceTemperatures places_c, std::uint64_t seed);

  /// Follows the places for one second, then reads them.
  void step(PlaceTemperatures places_c);

  [[nodiscard]] PlaceTemperatures readings_c() const { return readings_c_; }

 private:
  void drift();
  void read();
  void fail(const std::array<double, kThermalPlaces>& before_c);

  ThermometerParameters parameters_;
  RandomStream noise_;
  RandomStream drift_noise_;
  RandomStream spikes_;
  double seconds_{};
  EachThermometer follow_{};            ///< share of the difference closed in one second
  EachThermometer drift_per_sqrt_s_{};  ///< K
  bool drifts_ = false;
  EachThermometer drift_k_{};
  std::array<double, kThermalPlaces> sensed_c_{};
  std::array<double, kThermalPlaces> readings_c_{};
};

}  // namespace gyrotherm::simulator
