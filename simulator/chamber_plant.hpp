// SPDX-License-Identifier: Apache-2.0
/// The chamber: air driven by heater, cooler and wall, a controller that follows a set point, and the controller's
/// sensor.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/humidity.hpp"
#include "core/quantity.hpp"
#include "simulator/chamber_limiter.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm::simulator {

/// The water vapour in the chamber. It condenses on the coldest surface, remains there as frost, and evaporates when
/// the surface becomes warmer. Leaks and an open door exchange the air with the surroundings. Noise-free.
class ChamberVapour {
 public:
  explicit ChamberVapour(const PlantParameters& parameters)
      : outside_hpa_(saturation_over_water_hpa({parameters.room_c}) * parameters.room_humidity_percent / 100),
        exchange_s_(parameters.air_exchange_s),
        vapour_hpa_(std::min(outside_hpa_, saturation_hpa(parameters.start_c))) {}

  /// Advances by one second. `coldest_c` is the temperature of the coldest surface.
  void step(double coldest_c, bool door_open) {
    constexpr double kOpenDoorSeconds = 60, kEvaporationSeconds = 600;
    vapour_hpa_ += (outside_hpa_ - vapour_hpa_) / (door_open ? kOpenDoorSeconds : exchange_s_);
    const double excess_hpa = vapour_hpa_ - saturation_hpa(coldest_c);
    const double change_hpa = excess_hpa > 0 ? excess_hpa : std::max(-frost_hpa_, excess_hpa / kEvaporationSeconds);
    vapour_hpa_ -= change_hpa;
    frost_hpa_ += change_hpa;
  }

  [[nodiscard]] double pressure_hpa() const { return vapour_hpa_; }

 private:
  [[nodiscard]] static double saturation_hpa(double surface_c) {
    return surface_c < 0 ? saturation_over_ice_hpa({surface_c}) : saturation_over_water_hpa({surface_c});
  }

  double outside_hpa_;
  double exchange_s_;
  double vapour_hpa_;
  /// Vapour pressure that the condensed water had in the air.
  double frost_hpa_{};
};

/// Three first-order lags (air and wall, machinery, sensor) under a proportional-integral controller. The controller's
/// integral does not grow further while the output is at its limit. Integrated by explicit Euler with a step of 1 s.
/// Noise-free.
class ChamberPlant {
 public:
  explicit ChamberPlant(const PlantParameters& parameters)
      : parameters_(parameters),
        air_c_(parameters.start_c),
        wall_c_(parameters.start_c),
        sensed_c_(parameters.start_c),
        vapour_(parameters) {}

  /// Advances by one second. While the chamber is off, heater and cooler run down, and air and wall drift towards the
  /// room. The limiter switches it off, too.
  void step(Celsius set_point, bool is_commanded_on) {
    const auto& p = parameters_;
    limiter_.step(air_c_);
    const bool on = is_commanded_on && !limiter_.is_tripped();
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
    vapour_.step(std::min(air_c_, wall_c_), faults_.door_open);
  }

  /// Applies the faults from the next step on.
  void inject(const PlantFaults& faults) { faults_ = faults; }

  /// Holds the output at a fixed value, −1 … 1, regardless of the set point (manual mode). An empty value returns to
  /// closed-loop control.
  void hold_output(std::optional<double> output) { held_output_ = output; }

  [[nodiscard]] ChamberLimiter& limiter() { return limiter_; }

  [[nodiscard]] Celsius air() const { return {air_c_}; }
  /// Returns the air temperature that the sensor shows, including the sensor's lag and faults.
  [[nodiscard]] Celsius sensed_air() const { return {faults_.sensor_c.value_or(sensed_c_ + faults_.sensor_error_k)}; }
  /// Returns the relative humidity with respect to water, 0 … 100 %, and the dew point.
  [[nodiscard]] double humidity_percent() const {
    const double measured = 100 * vapour_.pressure_hpa() / saturation_over_water_hpa(air());
    return faults_.humidity_percent.value_or(std::min(100.0, measured));
  }
  [[nodiscard]] Celsius dew_point() const { return dew_point_at(vapour_.pressure_hpa()); }
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
  ChamberLimiter limiter_;
  double air_c_;
  double wall_c_;
  double sensed_c_;
  ChamberVapour vapour_;
  std::optional<double> held_output_;
  /// The integral of the controller, in units of its output.
  double integral_{};
  /// Output of heater (positive) and cooler (negative), −1 … 1.
  double output_{};
};

}  // namespace gyrotherm::simulator
