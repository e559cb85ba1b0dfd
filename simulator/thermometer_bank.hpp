/// The virtual thermometers: true temperatures → readings with lag, calibration error, noise and resolution.
#pragma once

#include <array>
#include <cstdint>

#include "simulator/gyro_thermal.hpp"
#include "simulator/random.hpp"
#include "simulator/world_parameters.hpp"

namespace gyrotherm {

/// `value` to the nearest multiple of `resolution` (0: as it is).
[[nodiscard]] double to_resolution(double value, double resolution);

class ThermometerBank {
 public:
  /// Starts in equilibrium with `places_c` and reads it once.
  ThermometerBank(const ThermometerParameters& parameters, PlaceTemperatures places_c, std::uint64_t seed);

  /// Follows the places for one second, then reads them.
  void step(PlaceTemperatures places_c);

  [[nodiscard]] PlaceTemperatures readings_c() const { return readings_c_; }

 private:
  void read();

  ThermometerParameters parameters_;
  double follow_;  ///< share of the difference closed in one second
  RandomStream noise_;
  std::array<double, kThermalPlaces> sensed_c_{};
  std::array<double, kThermalPlaces> readings_c_{};
};

}  // namespace gyrotherm
