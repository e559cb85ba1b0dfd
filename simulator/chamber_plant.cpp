// SPDX-License-Identifier: Apache-2.0
#include "simulator/chamber_plant.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm::simulator {
namespace {

constexpr double kAirByOpenDoorSeconds = 60;

}  // namespace

ChamberPlant::ChamberPlant(const PlantParameters& parameters)
    : parameters_(parameters), air_c_(parameters.start_c), wall_c_(parameters.start_c), sensed_c_(parameters.start_c) {}

void ChamberPlant::step(Celsius set_point, bool on) {
  const auto& p = parameters_;
  if (!on) integral_ = 0;
  const double wanted = on && std::isfinite(sensed().value) ? demand(set_point.value - sensed().value) : 0;

  const double room_k_per_s = faults_.door_open ? (p.room_c - air_c_) / kAirByOpenDoorSeconds : 0;
  const double air_k_per_s = machinery_k_per_s() + (wall_c_ - air_c_) / p.air_by_wall_s + room_k_per_s;
  const double wall_k_per_s = (air_c_ - wall_c_) / p.wall_by_air_s + (p.room_c - wall_c_) / p.wall_by_room_s;
  sensed_c_ += (air_c_ - sensed_c_) / p.sensor_s;
  output_ += (wanted - output_) / p.actuator_s;
  air_c_ += air_k_per_s;
  wall_c_ += wall_k_per_s;
}

Celsius ChamberPlant::sensed() const { return {faults_.sensor_c.value_or(sensed_c_ + faults_.sensor_error_k)}; }

double ChamberPlant::demand(double error_k) {
  const double proportional = parameters_.proportional_per_k * error_k;
  const double growth = proportional / parameters_.integral_time_s;
  const double wanted = proportional + integral_ + growth;
  const bool winds_up = (wanted > 1 && growth > 0) || (wanted < -1 && growth < 0);
  if (!winds_up) integral_ += growth;
  return std::clamp(wanted, -1.0, 1.0);
}

double ChamberPlant::machinery_k_per_s() const {
  const auto& p = parameters_;
  const double output = faults_.stuck_output.value_or(output_);
  const double share = output > 0 ? faults_.heating_share : faults_.cooling_share;
  const double above_20_k = air_c_ - 20;
  const double full_k_per_min = output > 0 ? p.heating_k_per_min + p.heating_slope_per_min * above_20_k
                                           : p.cooling_k_per_min + p.cooling_slope_per_min * above_20_k;
  return share * output * std::max(full_k_per_min, 0.0) / 60;
}

}  // namespace gyrotherm::simulator
