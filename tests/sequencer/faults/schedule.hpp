// SPDX-License-Identifier: Apache-2.0
/// What goes wrong in a simulated run, and when: a list that a seed draws, that can be written down and read back, and
/// cut short.
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
  chamber_exchanged,  ///< another chamber has its place, and its air
  chamber_answers_lost,
  chamber_lossy,  ///< size: share of the exchanges of which the request or the answer is lost
  chamber_late,
  chamber_doubled,
  chamber_noise,
  chamber_cut,
  chamber_exception,        ///< size: the code
  chamber_write_exception,  ///< … to writes alone
  chamber_foreign_unit,
  chamber_wrong_number,
  // the chamber
  chamber_ignores_writes,
  chamber_clamps,        ///< size: °C from zero
  chamber_restarts,      ///< at its default set point
  chamber_switched_off,  ///< at its panel
  chamber_manual,        ///< full heating, whatever its set point is
  panel_set_point,       ///< size: °C
  heater_weak,           ///< size: share of its power that is left
  cooler_weak,
  machinery_stuck,  ///< size: −1 … 1
  door_open,
  limiter_trips,
  filter_dirty,
  air_sensor_error,  ///< size: K
  air_sensor_frozen,
  air_sensor_broken,  ///< shows what cannot be
  // thermometers; the target is the channel, of a line the instrument
  thermometer_open,   ///< reads 850 °C
  thermometer_short,  ///< reads −200 °C
  thermometer_lost,   ///< shows no number
  thermometer_stuck,
  thermometer_spike,       ///< size: K
  thermometer_drift,       ///< size: K
  thermometers_swapped,    ///< the target and the next
  thermometer_alternates,  ///< size: °C that it shows in every second second
  thermometers_frozen,     ///< all channels of an instrument, which is the target
  thermometer_silent,
  thermometer_gone,
  thermometer_exchanged,  ///< another instrument has its place
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
  gyro_dead,  ///< it sends, and its counters stand still
  gyro_restarts,
  // the disk
  disk_full,
  disk_fails,       ///< at every operation
  disk_fails_once,  ///< size: at which operation from now
  disk_loses_syncs,
  disk_slow,   ///< size: s for a transaction
  disk_hangs,  ///< a write does not come back
  // the record's files, by another program; the target is the main file or its log
  file_removed,
  file_replaced,     ///< by a copy
  file_cut,          ///< size: to which share of its length
  file_overwritten,  ///< size: at which share of its length
  // time and program
  machine_sleeps,    ///< no tick, and nobody takes what instruments send
  wall_clock_steps,  ///< size: s
  program_late,      ///< no tick for so long
  program_crashes,   ///< and is resumed after so long
  program_stopped,   ///< by a signal, likewise
  outputs_blocked,   ///< nobody reads what it says
  power_cut,         ///< likewise, and what was not synced is lost
  operator_pauses,   ///< and resumes after so long
  operator_stops,
  operator_aborts,
  operators_at_once,  ///< several requests within a second; size: which
  unit_dropped,       ///< by an operator, and returned after so long; the target is the unit
  count
};

inline constexpr auto kInjectedFaultKinds = static_cast<std::size_t>(InjectedFaultKind::count);

struct InjectedFault {
  std::int64_t at{};  ///< second of the run at which it begins
  InjectedFaultKind kind{};
  int target{};
  std::int64_t lasts{};  ///< seconds; 0: it is no more than an instant
  double size{};
  bool operator==(const InjectedFault&) const = default;
};

using Schedule = std::vector<InjectedFault>;

struct ScheduleOptions {
  std::int64_t seconds = 3600;  ///< of the run, in which injected faults begin
  std::int64_t longest = 1200;  ///< of one injected fault
  int most = 8;                 ///< injected faults
  int units = 1;                ///< under test, each on a line of its own
};

/// In order of time. The seed enables some of the kinds, and draws from those alone.
[[nodiscard]] Schedule draw_schedule(std::uint64_t seed, const ScheduleOptions& options);

[[nodiscard]] const char* name(InjectedFaultKind kind);
/// "120 chamber_silent 0 30 0", one a line.
[[nodiscard]] std::string text(const InjectedFault& fault);
[[nodiscard]] std::string text(const Schedule& schedule);
/// Nothing if it is none.
[[nodiscard]] std::optional<InjectedFault> parse_fault(std::string_view line);

}  // namespace gyrotherm::faults
