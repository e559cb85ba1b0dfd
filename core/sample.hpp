// SPDX-License-Identifier: Apache-2.0
/// Data that the rig produces in one second, in plain structs. A struct is not modified after it has been filled.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/form.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// A value, or the fault that prevented it, with the instant of the reading.
template <class T>
struct Reading {
  Result<T> value;
  Instant at;
};

template <class T>
[[nodiscard]] std::optional<T> known_value(const Reading<T>& reading) {
  return reading.value ? std::optional<T>(*reading.value) : std::nullopt;
}

/// Pulses of all axes of a gyro in one second, the exact duration of the count, and the gyro's housekeeping values.
/// Empty for a unit that was dropped from the run.
struct GyroCount {
  std::vector<std::int64_t> pulses;  ///< one count per axis
  Duration interval{};
  /// Housekeeping values (internal temperature, discharge current, …). Each is the mean over the frames that contain
  /// it, or NaN if none does.
  std::vector<double> values{};
};

/// Counts of a gyro's frames: received intact (`seen`), missing (`lost`), and marked as bad by the gyro (`bad`). Bad
/// frames are part of `seen`.
struct FrameCount {
  std::uint64_t seen{};
  std::uint64_t lost{};
  std::uint64_t bad{};
  auto operator<=>(const FrameCount&) const = default;
};

void describe(auto& form, Like<FrameCount> auto& frames) {
  form("seen", frames.seen);
  form("lost", frames.lost);
  form("bad", frames.bad);
}

/// Activity that a controller reports. The enumerators from `program` to `holding` mean that it executes a program
/// stored in the controller.
enum class ChamberActivity {
  off,
  /// Controls the chamber at its set point.
  running,
  /// Controls the chamber without following its set point: manual output or open loop.
  not_following,
  /// Executes a stored program.
  program,
  ramping,
  soaking,
  /// The program waits for a condition.
  waiting,
  /// The program is held.
  holding,
  /// The program has ended.
  done,
  alarm,
  door_open,
  emergency_stop,
  power_failure,
  /// The controller does not report its activity, or was not queried.
  unknown,
};

/// Returns whether the controller executes a stored program, which overrules a set point.
[[nodiscard]] constexpr bool is_program_activity(ChamberActivity activity) {
  return activity >= ChamberActivity::program && activity <= ChamberActivity::holding;
}

enum class AlarmSeverity { note, warning, stop };

/// State of the chamber as its controller reports it. The set point is read back from the controller; it is NaN if it
/// cannot be read and none was sent. Activity, alarms and humidity are from the latest query, with the most severe
/// alarm first.
struct ChamberState {
  Celsius air;
  Celsius set_point;
  ChamberActivity activity = ChamberActivity::unknown;
  std::vector<std::string> alarms{};
  bool must_stop{};  ///< an alarm ends the run
  /// Relative humidity with respect to water, and dew point of the air; nothing if it is not measured or unknown.
  std::optional<double> humidity_percent{};
  std::optional<Celsius> dew_point{};
  auto operator<=>(const ChamberState&) const = default;
};

enum class Phase { ramping, holding, waiting_for_soak, overdue, complete };
inline constexpr std::initializer_list<Phase> kPhases = {Phase::ramping, Phase::holding, Phase::waiting_for_soak,
                                                         Phase::overdue, Phase::complete};
/// Position in the profile. A run can be resumed from its position and the profile.
struct ProfilePosition {
  /// Index into the expanded profile.
  int segment{};
  /// Index of the cycle to which the segment belongs, or -1.
  int cycle{-1};
  Phase phase{};
  /// Time spent in the segment so far.
  Duration in_segment{};
  Duration soaked{};  ///< part inside the soak band
  Celsius set_point;  ///< required by the profile now
  auto operator<=>(const ProfilePosition&) const = default;
};

/// State of a unit under test as set by the operators. By default the unit is switched on and in its normal mounting.
struct UnitState {
  bool off{};  ///< power switched off
  /// The input axis is reversed, and the Earth rate has the opposite sign.
  bool turned{};
  auto operator<=>(const UnitState&) const = default;
};

/// State of a run, after ISA-88 and PackML, in order of increasing severity.
enum class RunState {
  /// The time in the profile advances.
  execute,
  /// An external cause stopped the clock. The run resumes by itself when the cause is gone.
  suspended,
  /// An operator or an internal cause stopped the clock. Only an operator resumes the run.
  held,
  /// The chamber is being made safe; its confirmation is pending.
  aborting,
  /// The chamber has confirmed its safe state; no further command is sent.
  aborted,
  /// An operator ended the run.
  stopped,
  /// The profile ended.
  complete,
};
inline constexpr std::initializer_list<RunState> kRunStates = {
    RunState::execute, RunState::suspended, RunState::held,    RunState::aborting,
    RunState::aborted, RunState::stopped,   RunState::complete};
/// Returns whether the run was aborted or stopped: the chamber no longer follows the profile.
[[nodiscard]] constexpr bool has_left_profile(RunState state) {
  return state == RunState::aborting || state == RunState::aborted || state == RunState::stopped;
}

/// Readings of one unit under test in one second. The pulses of all axes and the housekeeping values come from one
/// instrument and succeed or fail together. Values from analogue inputs succeed or fail independently.
struct UnitReading {
  Reading<GyroCount> count;
  /// Values measured by analogue inputs. In the record they follow the values that the unit itself sends.
  std::vector<Reading<double>> analogue{};
  FrameCount frames{};  ///< since the rig was assembled
  /// True bias of each axis in this second. Empty unless the unit is virtual.
  std::vector<DegreesPerHour> true_bias{};
};

/// One second of the whole rig. `thermometers` has the order of the rig's channels; the values are not calibrated.
struct Sample {
  /// Whole seconds since the run started. Each second has one sample or belongs to one gap.
  std::int64_t slot{};
  Instant at;
  Reading<ChamberState> chamber;
  std::vector<Reading<Celsius>> thermometers;
  std::vector<UnitReading> units;  ///< in the order of the rig
  ProfilePosition progress;
  RunState state{};  ///< after evaluating this sample
};

/// Begins the fault of an instrument whose reading was not finished in its second. The instrument may answer later: it
/// is too slow rather than silent.
inline constexpr std::string_view kStillBusy = "still busy after ";
/// Returns true if an instrument did not answer. An answer without a valid value is an answer.
[[nodiscard]] inline bool means_no_answer(const Fault& fault) {
  return fault.kind == FaultKind::timeout || fault.kind == FaultKind::disconnected;
}

[[nodiscard]] inline bool is_still_busy(const Fault& fault) { return fault.what.starts_with(kStillBusy); }

/// Begins the end of a fault's text that quotes the last received line, which answers no question.
inline constexpr std::string_view kReceived = "; received ";
/// Returns that end: `; received "@04PV=+0021.0"`. Returns an empty text if the fault has none.
[[nodiscard]] inline std::string received_text(const std::string& fault) {
  const auto begin = fault.rfind(kReceived);
  return begin == std::string::npos ? "" : fault.substr(begin);
}

/// Status of a run, for programs and pages that display it.
struct RunOverview {
  RunState state{};
  /// Reason for the state; empty in the state execute.
  std::string cause{};
  /// An operator stopped the run, and the chamber is being made safe or is safe. Not an abort. Nothing if it is
  /// unknown, as in a file of an earlier version.
  std::optional<bool> stopped_by_operator{};
  /// Time to the end of the run, assuming that no soak is interrupted from now on.
  std::optional<Duration> time_left{};
  /// Time that passed while the profile's clock was stopped.
  std::optional<Duration> behind_plan{};
  std::int64_t missed_set_points{};  ///< not accepted by the chamber
  /// Set points whose confirmation did not arrive in time. The chamber may have them.
  std::int64_t unconfirmed_set_points{};
  std::vector<std::string> faults_now{};  ///< active faults, one line each
  auto operator<=>(const RunOverview&) const = default;
};

[[nodiscard]] inline const char* name(ChamberActivity activity) {
  return enumerator_text<ChamberActivity::unknown>(
      {"off", "running", "not following its set point", "program", "ramping", "soaking", "waiting", "holding", "done",
       "alarm", "door open", "emergency stop", "power failure", "unknown"},
      activity);
}
[[nodiscard]] inline const char* name(Phase phase) {
  return enumerator_text<Phase::complete>({"ramping", "holding", "waiting for soak", "overdue", "complete"}, phase);
}
[[nodiscard]] inline const char* name(RunState state) {
  return enumerator_text<RunState::complete>(
      {"execute", "suspended", "held", "aborting", "aborted", "stopped", "complete"}, state);
}

void describe(auto& form, Like<RunOverview> auto& overview) {
  form("state", one_of(overview.state, kRunStates));
  form("cause", overview.cause);
  form("time_left_s", optional_seconds(overview.time_left));
  form("behind_plan_s", optional_seconds(overview.behind_plan));
  form("missed_set_points", overview.missed_set_points);
  form("faults_now", overview.faults_now);
  form.if_present("unconfirmed_set_points", true, overview.unconfirmed_set_points);  // since 0.2.0
  form.if_present("stopped_by_operator", overview.stopped_by_operator.has_value(), overview.stopped_by_operator);
}

enum class EventKind {
  started,
  resumed,
  segment,
  fault,
  recovered,
  interlock,
  note,
  interrupted,
  finished,
  /// The run's state changed; the text gives the reason.
  state,
  /// An operator sent a command; the text names the operator.
  command,
  /// An operator dropped a unit under test.
  dropped,
  /// A dropped unit returned to the run.
  returned,
  /// An operator acknowledged an alarm; the text contains the operator's name and comment.
  acknowledged,
  /// A notification of an alarm was sent; the text names recipient and rule.
  told,
};
[[nodiscard]] inline const char* name(EventKind kind) {
  return enumerator_text<EventKind::told>(
      {"started", "resumed", "segment", "fault", "recovered", "interlock", "note", "interrupted", "finished", "state",
       "command", "dropped", "returned", "acknowledged", "told"},
      kind);
}

/// Object that an event concerns, if there is exactly one.
struct EventSubject {
  /// Identifier and reaction of the interlock.
  std::string interlock{};
  std::string reaction{};
  /// Segment of the profile, if the event belongs to a run.
  std::optional<int> segment{};
  std::string channel{};
};
struct Event {
  Instant at;
  EventKind kind{};
  std::string text;
  EventSubject about{};
  /// Row in the record's table of events; 0 if the event is not recorded yet.
  std::int64_t number{};
};

}  // namespace gyrotherm
