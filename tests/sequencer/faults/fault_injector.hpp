// SPDX-License-Identifier: Apache-2.0
/// Carries out what a schedule says, on the plant.
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

  /// What begins and ends with this second. Returns those injected faults that have begun and are the program's and the
  /// operator's, not the plant's.
  [[nodiscard]] std::vector<InjectedFault> pass(std::int64_t second);

  /// That stand now, by their nature until they end.
  [[nodiscard]] const std::vector<InjectedFault>& standing() const { return standing_; }
  /// The second in which the last one ended, or began where it is an instant; −1: none yet.
  [[nodiscard]] std::int64_t last_change() const { return last_change_; }
  [[nodiscard]] bool any_begun() const { return next_ > 0; }

 private:
  [[nodiscard]] std::size_t gyro_of(const InjectedFault& fault) const;
  void happen(const InjectedFault& fault);
  void settle();
  void stand(const InjectedFault& fault);
  void stand_on_line(const InjectedFault& fault);
  void exchange(const InjectedFault& fault, LineEnd& line);
  void stand_in_chamber(const InjectedFault& fault);
  void stand_in_thermometer(const InjectedFault& fault);

  Schedule schedule_;
  Plant& plant_;
  SimulatedClock& clock_;
  std::size_t next_ = 0;
  std::vector<InjectedFault> standing_;
  /// Readings at the start of each injected fault: the thermometers, then the air.
  std::vector<std::vector<double>> shown_then_;
  std::int64_t second_ = 0;
  std::int64_t last_change_ = -1;
};

/// Done to the record's files by another program.
[[nodiscard]] bool is_of_record(InjectedFaultKind kind);
/// Of the program, its machine, its record or the operator, not of the plant.
[[nodiscard]] bool is_of_program(InjectedFaultKind kind);

}  // namespace gyrotherm::faults
