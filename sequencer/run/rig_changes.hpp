// SPDX-License-Identifier: Apache-2.0
/// Finds the changes of a rig from one second to the next, and describes them for the record: readings that become
/// faults or return, the chamber's own alarms, and the alarms of the interlocks with their roots. One thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/run/alarm_roots.hpp"

namespace gyrotherm::run {

/// An event without its time.
struct RigChange {
  EventKind kind{};
  std::string text;
  EventSubject about{};
};

class RigChanges {
 public:
  /// `rig` must outlive this object.
  explicit RigChanges(const rig::RigFile& rig) : rig_(rig), lines_(rig_lines(rig)) {}

  /// Compares the readings and the chamber's alarms with the previous sample. Ignores the `dropped` units. If
  /// `units_may_be_off`, the silence of a unit is not a fault.
  [[nodiscard]] std::vector<RigChange> compare_readings(const Sample& sample, const std::vector<bool>& dropped,
                                                        bool units_may_be_off);
  /// Counts the faulty readings of the last sample, without those of units that may be off.
  [[nodiscard]] std::int64_t faulty_readings() const { return faulty_readings_; }
  /// Counts the missing readings of units that may be off in the last sample.
  [[nodiscard]] std::int64_t readings_while_off() const { return readings_while_off_; }

  /// Returns the alarms that are raised or return to normal in this second. `missed` is the time without ticks before
  /// this second. In the result, a raised root precedes its consequences, and a cleared root follows them.
  [[nodiscard]] std::vector<RigChange> compare_alarms(const interlocks::InterlockResult& result, const Sample& sample,
                                                      Duration missed);

 private:
  const rig::RigFile& rig_;
  std::vector<RigLine> lines_;
  RootMemory roots_;
  std::vector<bool> is_faulty_;  ///< per channel
  /// Alarms in the last reading.
  std::vector<std::string> chamber_alarms_;
  std::int64_t faulty_readings_{}, readings_while_off_{};
};

}  // namespace gyrotherm::run
