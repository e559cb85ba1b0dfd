/// What is broken in the virtual laboratory.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "simulator/virtual_gyro.hpp"

namespace gyrotherm {

/// Of the chamber; by default nothing is broken.
struct PlantFaults {
  double heating_share = 1, cooling_share = 1;  ///< of the machinery's power that is left
  std::optional<double> stuck_output{};  ///< −1 … 1: what heater and cooler do, whatever the controller wants of them
  bool door_open{};                      ///< the room pulls at the air
  double sensor_error_k{};               ///< of the chamber's own sensor, by which its controller goes
  std::optional<double> sensor_c{};      ///< what the sensor shows instead, if anything
};

/// Of one thermometer on the article.
struct ThermometerFault {
  std::size_t place{};              ///< where it is: somewhere else after cables were swapped
  double error_k{};                 ///< added to what it shows
  std::optional<double> shown_c{};  ///< what it shows instead, if anything
};

struct LaboratoryFaults {
  LaboratoryFaults() {
    for (std::size_t i = 0; i < thermometers.size(); ++i) thermometers[i].place = i;
  }
  PlantFaults plant;
  std::array<ThermometerFault, kThermalPlaces> thermometers;  ///< A…H, shell
};

}  // namespace gyrotherm
