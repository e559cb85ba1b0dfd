// SPDX-License-Identifier: Apache-2.0
/// A schedule of faults in a simulated run. It is drawn from a seed, can be written as text and read back, and can be
/// shortened.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::faults {

enum class InjectedFaultKind {
  // the chamber's line
  chamber_silent,
  chamber_gone,
  chamber_half_open,
  /// Another chamber is connected at the same address, in the same air.
  chamber_exchanged,
  chamber_answers_lost,
  /// Size: share of exchanges that lose the request or the answer.
  chamber_lossy,
  chamber_late,
  chamber_doubled,
  chamber_noise,
  chamber_cut,
  chamber_exception,  ///< size: the code
  /// As above, but only for writes; size: the code.
  chamber_write_exception,
  chamber_foreign_unit,
  chamber_wrong_number,
  // the chamber
  chamber_ignores_writes,
  /// Size: largest magnitude that is applied, °C.
  chamber_clamps,
  /// Restarts with its default set point.
  chamber_restarts,
  chamber_switched_off,  ///< at its panel
  /// Full heating, regardless of its set point.
  chamber_manual,
  panel_set_point,  ///< size: °C
  /// Size: remaining share of its power.
  heater_weak,
  cooler_weak,
  /// Size: −1 … 1.
  machinery_stuck,
  door_open,
  limiter_trips,
  filter_dirty,
  air_sensor_error,  ///< size: K
  air_sensor_frozen,
  /// Reads an impossible value.
  air_sensor_broken,
  // Thermometers. The target is the channel; for a line, the instrument.
  thermometer_open,   ///< reads 850 °C
  thermometer_short,  ///< reads −200 °C
  thermometer_lost,   ///< shows no number
  thermometer_stuck,
  thermometer_spike,  ///< size: K
  thermometer_drift,  ///< size: K
  /// The target channel and the next one.
  thermometers_swapped,
  /// Size: °C shown in every other second.
  thermometer_alternates,
  /// Affects all channels of the target instrument.
  thermometers_frozen,
  thermometer_silent,
  thermometer_gone,
  /// Another instrument is connected in its place.
  thermometer_exchanged,
  thermometer_lossy,
  thermometer_noise,
  thermometer_late,
  thermometer_doubled,
  // the gyro
  gyro_silent,
  gyro_gone,
  gyro_garbled,
  gyro_loses_frames,
  gyro_bursts,
  /// Sends frames with stopped counters.
  gyro_dead,
  gyro_restarts,
  // the disk
  disk_full,
  disk_fails,  ///< at every operation
  /// Size: number of operations before the failure.
  disk_fails_once,
  disk_loses_syncs,
  /// Size: s per transaction.
  disk_slow,
  /// A write does not return.
  disk_hangs,
  // The record's files, changed by another program. The target is the main file or its log.
  file_removed,
  /// A copy replaces it.
  file_replaced,
  /// Size: remaining share of its length.
  file_cut,
  /// Size: position as share of its length.
  file_overwritten,
  // time and program
  /// No tick, and instruments are not read.
  machine_sleeps,
  wall_clock_steps,  ///< size: s
  /// No tick for the duration.
  program_late,
  /// The program is resumed after the duration.
  program_crashes,
  /// A signal stops it; it is resumed after the duration.
  program_stopped,
  /// The output is not read.
  outputs_blocked,
  /// The program is resumed after the duration; data that was not synced is lost.
  power_cut,
  /// The operator resumes after the duration.
  operator_pauses,
  operator_stops,
  operator_aborts,
  /// Several requests within a second; size: selection.
  operators_at_once,
  /// An operator drops the target unit, and returns it after the duration.
  unit_dropped,
  count
};

inline constexpr auto kInjectedFaultKinds = static_cast<std::size_t>(InjectedFaultKind::count);

struct InjectedFault {
  /// Second of the run at which it begins.
  std::int64_t at{};
  InjectedFaultKind kind{};
  int target{};
  std::int64_t lasts{};  ///< seconds; 0: instantaneous
  double size{};
  bool operator==(const InjectedFault&) const = default;
};

using Schedule = std::vector<InjectedFault>;

struct ScheduleOptions {
  /// Faults begin within this time from the start of the run.
  std::int64_t seconds = 3600;
  std::int64_t longest = 1200;  ///< longest fault
  int most = 8;                 ///< number of faults
  /// Units under test, each on its own line.
  int units = 1;
};

/// Draws a schedule in order of time. Selects some kinds of fault from the seed and draws the faults from these kinds.
[[nodiscard]] Schedule draw_schedule(std::uint64_t seed, const ScheduleOptions& options);

[[nodiscard]] const char* name(InjectedFaultKind kind);
/// Writes faults as "120 chamber_silent 0 30 0", one per line.
[[nodiscard]] std::string text(const InjectedFault& fault);
[[nodiscard]] std::string text(const Schedule& schedule);
/// Parses a line. Returns nothing if it is not a fault.
[[nodiscard]] std::optional<InjectedFault> parse_fault(std::string_view line);

}  // namespace gyrotherm::faults
