// SPDX-License-Identifier: Apache-2.0
/// What is broken in the virtual laboratory.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/toml_reader.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm::simulator {

/// Of the chamber; by default nothing is broken.
struct PlantFaults {
  double heating_share = 1, cooling_share = 1;  ///< of the machinery's power that is left
  std::optional<double> stuck_output{};  ///< −1 … 1: what heater and cooler do, whatever the controller wants of them
  bool door_open{};                      ///< the room pulls at the air
  double sensor_error_k{};               ///< of the chamber's own sensor, by which its controller goes
  std::optional<double> sensor_c{};      ///< what the sensor shows instead, if anything
};

/// Of one thermometer on a unit.
struct ThermometerFault {
  std::size_t place{};              ///< whose place it has: another one's after cables were swapped
  double error_k{};                 ///< added to what it shows
  std::optional<double> shown_c{};  ///< what it shows instead, if anything
};

struct LaboratoryFaults {
  /// Nothing is broken; of a plain world each thermometer can be, else as many.
  LaboratoryFaults() : LaboratoryFaults(kThermalPlaces) {}
  explicit LaboratoryFaults(std::size_t count) : thermometers(count) {
    for (std::size_t i = 0; i < count; ++i) thermometers[i].place = i;
  }
  PlantFaults plant;
  bool air_is_frozen{};  ///< the controller shows the last reading
  /// In the order of VirtualLaboratory::thermometer_names(); those beyond them are sound.
  std::vector<ThermometerFault> thermometers;
};

// Pieces of the reader of a rig file's [virtual] table.

/// Numbers with a condition; one that breaks it is a mistake at its key.
[[nodiscard]] double positive(const TomlTable& table, const char* key);
[[nodiscard]] double not_negative(const TomlTable& table, const char* key, std::optional<double> fallback = {});
/// A time constant that a step of one second can follow.
[[nodiscard]] double time_constant_s(const TomlTable& table, const char* key, std::optional<double> fallback = {});
/// As many numbers as wanted, none below `least`; on a mistake that many zeros.
[[nodiscard]] std::vector<double> numbers(const TomlTable& table, const char* key, std::size_t count, double least);

/// Whether a [virtual] table has [[virtual.unit]].
[[nodiscard]] bool has_units(const TomlTable& table);

/// [[virtual.unit]], [[virtual.bracket]], [virtual.own_temperature] and [[virtual.value]] into `laboratory`, whose
/// read-out has been read.
void read_units(const TomlTable& table, LaboratoryParameters& laboratory);

/// Of a world of units: gives failing thermometers, whose places are counted over all thermometer_names_of, to the axes
/// that they sit on.
void give_to_axes(std::vector<FailingThermometer>& failing, std::vector<UnitParameters>& units);

/// [virtual.network] and [virtual.bias] of a rig whose body is "reference".
[[nodiscard]] LumpedGyroParameters read_lumped_gyro(const TomlTable& table);

/// [virtual.thermal] with its spread, and [virtual.bias] of a rig whose body is "twin". The model is left
/// empty: another file has it.
[[nodiscard]] ReducedGyroParameters read_reduced_gyro(const TomlTable& table);

}  // namespace gyrotherm::simulator
