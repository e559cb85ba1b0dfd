// SPDX-License-Identifier: Apache-2.0
/// The chamber: air that heater, cooler and wall pull at, a controller that follows its set point, and the controller's
/// sensor.
#pragma once

#include "core/quantity.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm::simulator {

/// Three first-order lags (air and wall, machinery, sensor) under a proportional-integral controller whose integral
/// stops while the output is at its limit. Explicit Euler, 1 s. Free of noise.
class ChamberPlant {
 public:
  explicit ChamberPlant(const PlantParameters& parameters);

  /// Lets one second pass. Switched off, heater and cooler run down and air and wall drift towards the room.
  void step(Celsius set_point, bool on);
  /// From the next step on.
  void inject(const PlantFaults& faults) { faults_ = faults; }

  [[nodiscard]] Celsius air() const { return {air_c_}; }
  [[nodiscard]] Celsius sensed() const;                                  ///< behind the sensor's lag, or what it shows
  [[nodiscard]] double output_percent() const { return 100 * output_; }  ///< −100 full cooling … 100 full heating

 private:
  [[nodiscard]] double demand(double error_k);
  [[nodiscard]] double machinery_k_per_s() const;

  PlantParameters parameters_;
  PlantFaults faults_;
  double air_c_;
  double wall_c_;
  double sensed_c_;
  double integral_{};  ///< the controller's, in units of its output
  double output_{};    ///< of heater (positive) and cooler (negative), −1…1
};

}  // namespace gyrotherm::simulator
