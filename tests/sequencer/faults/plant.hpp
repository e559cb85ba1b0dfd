// SPDX-License-Identifier: Apache-2.0
/// The virtual laboratory outside the program. It continues while no program runs, and breaks on command.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sequencer/rig/rig_file.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "simulator/virtual_supply.hpp"
#include "tests/sequencer/faults/chamber_port.hpp"
#include "tests/sequencer/faults/gyro_end.hpp"
#include "tests/sequencer/faults/memory_line.hpp"

namespace gyrotherm::faults {

class Plant {
 public:
  Plant(const rig::RigFile& file, const simulator::LaboratoryParameters& parameters, const Clock& rig,
        std::uint64_t seed);
  Plant(const Plant&) = delete;

  void apply_faults() { laboratory_.inject(faults); }

  /// Advances by one second, and lets the gyros send their frames.
  void advance_second();
  /// Restarts the controller at `set_point`, switched on or off.
  void restart_chamber(Celsius set_point, bool on);
  /// Writes an item of the chamber's map, as an operator does at the panel.
  void write(const char* item, double value);

  [[nodiscard]] simulator::VirtualLaboratory& laboratory() { return laboratory_; }
  [[nodiscard]] ChamberPort& chamber() { return chamber_port_; }
  [[nodiscard]] std::size_t thermometer_count() const { return thermometers_.size(); }
  [[nodiscard]] LineEnd& thermometer(std::size_t index) { return *thermometers_[index]; }
  /// Returns the positions of a thermometer instrument's channels in the laboratory.
  [[nodiscard]] const std::vector<std::size_t>& places(std::size_t index) const { return places_[index]; }
  /// Puts another instrument in the position of a thermometer, or removes it again.
  void exchange_thermometer(std::size_t index, bool is_another) { *are_exchanged_[index] = is_another; }
  [[nodiscard]] bool is_exchanged(std::size_t thermometer) const { return *are_exchanged_[thermometer]; }
  [[nodiscard]] simulator::VirtualSupply& supply(std::size_t index = 0) { return *supplies_[index]; }
  [[nodiscard]] LineEnd& supply_line(std::size_t index) { return *supply_lines_[index]; }
  [[nodiscard]] std::size_t gyro_count() const { return gyros_.size(); }
  [[nodiscard]] GyroEnd& gyro(std::size_t line = 0) { return *gyros_[line]; }

 private:
  simulator::VirtualLaboratory laboratory_;

 public:
  /// Active after the next apply_faults().
  simulator::LaboratoryFaults faults;

 private:
  simulator::ChamberRegisters registers_;
  ChamberPort chamber_port_;
  std::vector<std::unique_ptr<simulator::Session>> sessions_;
  /// One flag per thermometer. The thermometer's line refers to its address.
  std::vector<std::unique_ptr<bool>> are_exchanged_;
  std::vector<std::unique_ptr<LineEnd>> thermometers_;
  /// Positions of each thermometer's channels.
  std::vector<std::vector<std::size_t>> places_;
  std::vector<std::unique_ptr<GyroEnd>> gyros_;  ///< one per line
  std::vector<std::unique_ptr<simulator::VirtualSupply>> supplies_;
  std::vector<std::unique_ptr<LineEnd>> supply_lines_;

  void add_supply(const rig::SupplySettings& settings, const rig::RigFile& file, const Clock& rig, std::uint64_t seed);
};

}  // namespace gyrotherm::faults
