// SPDX-License-Identifier: Apache-2.0
/// Applies the faults of a schedule to the plant.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/sequencer/faults/plant.hpp"
#include "tests/sequencer/faults/schedule.hpp"

namespace gyrotherm::faults {

class FaultInjector {
 public:
  FaultInjector(Schedule schedule, Plant& plant, SimulatedClock& clock)
      : schedule_(std::move(schedule)), plant_(plant), clock_(clock) {}

  /// Begins and ends the faults of this second. Returns the faults that have begun and concern the program or the
  /// operator, not the plant.
  [[nodiscard]] std::vector<InjectedFault> pass(std::int64_t second);

  /// Returns the active faults. An instantaneous fault remains active while its effect lasts.
  [[nodiscard]] const std::vector<InjectedFault>& active_faults() const { return active_; }
  /// Returns the second in which the last fault ended, or began if it is instantaneous; −1: none.
  [[nodiscard]] std::int64_t last_change() const { return last_change_; }
  [[nodiscard]] bool has_any_begun() const { return next_ > 0; }

 private:
  [[nodiscard]] std::size_t gyro_index(const InjectedFault& fault) const;
  void start_event(const InjectedFault& fault);
  void update_plant();
  void apply_fault(const InjectedFault& fault);
  void apply_to_line(const InjectedFault& fault);
  void exchange(const InjectedFault& fault, LineEnd& line);
  void apply_to_chamber(const InjectedFault& fault);
  void apply_to_thermometer(const InjectedFault& fault);

  Schedule schedule_;
  Plant& plant_;
  SimulatedClock& clock_;
  std::size_t next_ = 0;
  std::vector<InjectedFault> active_;
  /// Readings at the start of each fault: the thermometers, then the air.
  std::vector<std::vector<double>> shown_then_;
  std::int64_t second_ = 0;
  std::int64_t last_change_ = -1;
};

/// Returns true for a fault of the record's files by another program.
[[nodiscard]] bool concerns_record(InjectedFaultKind kind);
/// Returns true for a fault of the program, its machine, its record or the operator.
[[nodiscard]] bool concerns_program(InjectedFaultKind kind);

}  // namespace gyrotherm::faults
