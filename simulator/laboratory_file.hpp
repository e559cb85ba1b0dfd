// SPDX-License-Identifier: Apache-2.0
/// Faults of the virtual laboratory, and the reader of a rig file's [virtual] table.
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

/// Faults of the chamber. Nothing is broken by default.
struct PlantFaults {
  /// Share of the machinery's power that remains.
  double heating_share = 1, cooling_share = 1;
  /// Output of heater and cooler regardless of the controller, −1 … 1.
  std::optional<double> stuck_output{};
  bool door_open{};
  /// Error of the chamber's own sensor, which its controller uses.
  double sensor_error_k{};
  /// Constant value that the sensor reports instead of the temperature; absent: it measures.
  std::optional<double> sensor_c{};
  /// Constant value of the humidity sensor; absent: it measures.
  std::optional<double> humidity_percent{};
};

/// Faults of one thermometer on a unit.
struct ThermometerFault {
  /// Index of the measured location. It differs from the thermometer's own index if cables are swapped.
  std::size_t location{};
  /// Constant error that is added to the reading.
  double error_k{};
  /// Constant reading in place of the measured value; absent: the thermometer measures.
  std::optional<double> shown_c{};
};

struct LaboratoryFaults {
  /// Creates the state without faults. A laboratory without units has kThermalLocations thermometers, one with units
  /// has `count`.
  LaboratoryFaults() : LaboratoryFaults(kThermalLocations) {}
  explicit LaboratoryFaults(std::size_t count) : thermometers(count) {
    for (std::size_t i = 0; i < count; ++i) thermometers[i].location = i;
  }
  PlantFaults plant;
  /// True if the controller keeps showing its last reading.
  bool air_is_frozen{};
  /// Faults in the order of VirtualLaboratory::thermometer_names(). Thermometers that the list does not contain have
  /// none.
  std::vector<ThermometerFault> thermometers;
};

// Parts of the reader of a rig file's [virtual] table that several files share.

/// Reads a number and checks its sign. Reports an error at the key if the check fails.
[[nodiscard]] double positive(const TomlTable& table, const char* key);
[[nodiscard]] double not_negative(const TomlTable& table, const char* key, std::optional<double> fallback = {});
/// Reads a time constant. It must be at least the step of one second.
[[nodiscard]] double time_constant_s(const TomlTable& table, const char* key, std::optional<double> fallback = {});
/// Reads `count` numbers, none below `least`. If the list is invalid, reports an error at the key and still returns
/// `count` numbers.
[[nodiscard]] std::vector<double> numbers(const TomlTable& table, const char* key, std::size_t count, double least);

/// Returns whether a [virtual] table contains [[virtual.unit]].
[[nodiscard]] bool has_units(const TomlTable& table);

/// Reads [[virtual.unit]], [[virtual.bracket]], [virtual.own_temperature] and [[virtual.value]] into `laboratory`.
/// `laboratory.gyro` must have been read before.
void read_units(const TomlTable& table, LaboratoryParameters& laboratory);

/// In a laboratory with units, distributes failing thermometers to the axes that carry them. Before the call their
/// `index` is an index in list_thermometer_names(); afterwards it is an index in the axis' own thermometers.
void assign_failures_to_axes(std::vector<FailingThermometer>& failing, std::vector<UnitParameters>& units);

/// Reads [virtual.network] and [virtual.bias] of a rig with the body "reference".
[[nodiscard]] LumpedGyroParameters read_lumped_gyro(const TomlTable& table);

/// Reads [virtual.thermal] with its spread, and [virtual.bias] of a rig with the body "twin". The model remains empty,
/// because it is in another file.
[[nodiscard]] ReducedGyroParameters read_reduced_gyro(const TomlTable& table);

}  // namespace gyrotherm::simulator
