// SPDX-License-Identifier: Apache-2.0
/// The chamber: air driven by heater, cooler and wall, a controller that follows a set point, and the controller's
/// sensor.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/quantity.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm::simulator {

/// Three first-order lags (air and wall, machinery, sensor) under a proportional-integral controller. The controller's
/// integral does not grow further while the output is at its limit. Integrated by explicit Euler with a step of 1 s.
/// Noise-free.
class ChamberPlant {
 public:
  explicit ChamberPlant(const PlantParameters& parameters)
      : parameters_(parameters),
        air_c_(parameters.start_c),
        wall_c_(parameters.start_c),
        sensed_c_(parameters.start_c) {}

  /// Advances by one second. While the chamber is off, heater and cooler run down, and air and wall drift towards the
  /// room.
  void step(Celsius set_point, bool on) {
    const auto& p = parameters_;
    if (!on) integral_ = 0;
    const double controlled =
        on && std::isfinite(sensed_air().value) ? update_controller(set_point.value - sensed_air().value) : 0;
    const double wanted = on && held_output_ ? *held_output_ : controlled;

    constexpr double kAirByOpenDoorSeconds = 60;
    const double room_k_per_s = faults_.door_open ? (p.room_c - air_c_) / kAirByOpenDoorSeconds : 0;
    const double air_k_per_s = machinery_k_per_s() + (wall_c_ - air_c_) / p.air_by_wall_s + room_k_per_s;
    const double wall_k_per_s = (air_c_ - wall_c_) / p.wall_by_air_s + (p.room_c - wall_c_) / p.wall_by_room_s;
    sensed_c_ += (air_c_ - sensed_c_) / p.sensor_s;
    output_ += (wanted - output_) / p.actuator_s;
    air_c_ += air_k_per_s;
    wall_c_ += wall_k_per_s;
  }

  /// Applies the faults from the next step on.
  void inject(const PlantFaults& faults) { faults_ = faults; }

  /// Holds the output at a fixed value, −1 … 1, regardless of the set point (manual mode). An empty value returns to
  /// closed-loop control.
  void hold_output(std::optional<double> output) { held_output_ = output; }

  [[nodiscard]] Celsius air() const { return {air_c_}; }
  /// Returns the air temperature that the sensor shows, including the sensor's lag and faults.
  [[nodiscard]] Celsius sensed_air() const { return {faults_.sensor_c.value_or(sensed_c_ + faults_.sensor_error_k)}; }
  /// Returns the output: −100 (full cooling) … 100 (full heating).
  [[nodiscard]] double output_percent() const { return 100 * output_; }

 private:
  [[nodiscard]] double update_controller(double error_k) {
    const double proportional = parameters_.proportional_per_k * error_k;
    const double growth = proportional / parameters_.integral_time_s;
    const double wanted = proportional + integral_ + growth;
    const bool winds_up = (wanted > 1 && growth > 0) || (wanted < -1 && growth < 0);
    if (!winds_up) integral_ += growth;
    return std::clamp(wanted, -1.0, 1.0);
  }

  [[nodiscard]] double machinery_k_per_s() const {
    const auto& p = parameters_;
    const double output = faults_.stuck_output.value_or(output_);
    const double share = output > 0 ? faults_.heating_share : faults_.cooling_share;
    const double above_20_k = air_c_ - 20;
    const double full_k_per_min = output > 0 ? p.heating_k_per_min + p.heating_slope_per_min * above_20_k
                                             : p.cooling_k_per_min + p.cooling_slope_per_min * above_20_k;
    return share * output * std::max(full_k_per_min, 0.0) / 60;
  }

  PlantParameters parameters_;
  PlantFaults faults_;
  double air_c_;
  double wall_c_;
  double sensed_c_;
  std::optional<double> held_output_;
  /// The integral of the controller, in units of its output.
  double integral_{};
  /// Output of heater (positive) and cooler (negative), −1 … 1.
  double output_{};
};

}  // namespace gyrotherm::simulator
