// SPDX-License-Identifier: Apache-2.0
/// What one second of the rig is made of. Plain structs, made in one place, never edited after.
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

/// A value or the fault that stands in its place, with the instant it was taken.
template <class T>
struct Reading {
  Result<T> value;
  Instant at;
};

template <class T>
[[nodiscard]] std::optional<T> value_of(const Reading<T>& reading) {
  return reading.value ? std::optional<T>(*reading.value) : std::nullopt;
}

/// What a gyro, with all its axes, counted in a second, over exactly how long by its own clock, and what it told of
/// itself meanwhile. Of a unit that was dropped from the run there is nothing in it.
struct GyroCount {
  std::vector<std::int64_t> pulses;  ///< of each axis
  Duration interval{};
  std::vector<double> values{};  ///< its housekeeping (own temperature, discharge current …), each the mean of the
                                 ///< frames that had it; NaN where none had
};

/// How many frames of a gyro's stream came whole and intact; how many more the stream itself shows to be missing; and
/// how many of those seen the gyro marked as bad.
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

/// What a controller says that it is doing.
enum class ChamberActivity {
  off,
  running,  ///< it conditions at its set point
  /// It conditions and does not follow its set point: a manual output, an open loop.
  not_following,
  program,  ///< it carries out a program of its own
  ramping,  ///< it carries out a ramp of its program
  soaking,  ///< it carries out a soak of its program
  waiting,  ///< its program waits for a condition
  holding,  ///< its program is held
  done,     ///< its program has ended
  alarm,
  door_open,
  emergency_stop,
  power_failure,
  unknown,  ///< it does not say, or was not asked
};

/// Whether it says that the controller carries out a program of its own, which overrules a set point.
[[nodiscard]] constexpr bool carries_out_program(ChamberActivity activity) {
  return activity >= ChamberActivity::program && activity <= ChamberActivity::holding;
}

enum class AlarmSeverity { note, warning, stop };

/// What the chamber says of itself. The set point is the one that the controller holds, read back; NaN if it cannot be
/// read and none was sent. Activity and alarms are what it said when it was last asked; the gravest alarm comes first.
struct ChamberState {
  Celsius air;
  Celsius set_point;
  ChamberActivity activity = ChamberActivity::unknown;
  std::vector<std::string> alarms{};
  bool must_stop{};  ///< one of the alarms ends a run
  auto operator<=>(const ChamberState&) const = default;
};

/// Where the profile stands; enough, with the profile, to go on from here.
enum class Phase { ramping, holding, waiting_for_soak, overdue, complete };
inline constexpr std::initializer_list<Phase> kPhases = {Phase::ramping, Phase::holding, Phase::waiting_for_soak,
                                                         Phase::overdue, Phase::complete};
struct ProfilePosition {
  int segment{};          ///< index into the expanded profile
  int cycle{-1};          ///< index of the cycle the segment belongs to, or -1
  Phase phase{};          ///< what the segment is doing
  Duration in_segment{};  ///< time spent in the segment so far
  Duration soaked{};      ///< of it, inside the soak band
  Celsius set_point;      ///< what the profile asks of the chamber now
  auto operator<=>(const ProfilePosition&) const = default;
};

/// How people have left the unit under test: switched on and as mounted, unless they were asked for something else.
struct UnitState {
  bool off{};     ///< its power is switched off
  bool turned{};  ///< its input axis points the other way: the Earth's rate on it has the other sign
  auto operator<=>(const UnitState&) const = default;
};

/// How the run is being carried out, in the words of ISA-88 and PackML; milder first.
enum class RunState {
  execute,    ///< the profile's clock runs
  suspended,  ///< a cause outside the program stopped the clock; goes on by itself when the cause is gone
  held,       ///< an operator, or a cause inside, stopped the clock; only an operator goes on
  aborting,   ///< the chamber is being made safe, and has not confirmed it yet
  aborted,    ///< the chamber has confirmed that it is safe; nothing more is commanded
  stopped,    ///< an operator ended the run
  complete,   ///< the profile came to its end
};
inline constexpr std::initializer_list<RunState> kRunStates = {
    RunState::execute, RunState::suspended, RunState::held,    RunState::aborting,
    RunState::aborted, RunState::stopped,   RunState::complete};

/// One unit under test in one second. Its axes and the values that it sends have one instrument: they come together or
/// not at all. What analogue inputs measure of it are values of it too, and come each by itself.
struct UnitReading {
  Reading<GyroCount> count;
  std::vector<Reading<double>> analogue{};  ///< the last of its values, behind those that it sends
  FrameCount frames{};                      ///< counted since the rig was assembled
  std::vector<DegreesPerHour> true_bias{};  ///< of a virtual one, in this second, of each axis, as its laboratory knows
};

/// One second of the whole rig. `thermometers` is in the order of the rig's channels, as read (not calibrated).
struct Sample {
  std::int64_t slot{};  ///< whole seconds since the run started; each has one sample or lies in one gap
  Instant at;
  Reading<ChamberState> chamber;
  std::vector<Reading<Celsius>> thermometers;
  std::vector<UnitReading> units;  ///< in the order of the rig's units under test
  ProfilePosition progress;
  RunState state{};  ///< what was judged at this sample
};

/// Where a run stands and where it goes, for whoever watches it.
struct RunStanding {
  RunState state{};
  std::string cause{};                    ///< why the state is not execute; empty if it is
  std::optional<Duration> time_left{};    ///< what is left if every soak counts from now on
  std::optional<Duration> behind_plan{};  ///< time that went by without the profile's clock
  std::int64_t missed_set_points{};       ///< how many the chamber did not take so far
  std::vector<std::string> faults_now{};  ///< that stand, one line each
  auto operator<=>(const RunStanding&) const = default;
};

[[nodiscard]] inline const char* name(ChamberActivity activity) {
  return word_in<ChamberActivity::unknown>(
      {"off", "running", "not following its set point", "program", "ramping", "soaking", "waiting", "holding", "done",
       "alarm", "door open", "emergency stop", "power failure", "unknown"},
      activity);
}
[[nodiscard]] inline const char* name(Phase phase) {
  return word_in<Phase::complete>({"ramping", "holding", "waiting for soak", "overdue", "complete"}, phase);
}
[[nodiscard]] inline const char* name(RunState state) {
  return word_in<RunState::complete>({"execute", "suspended", "held", "aborting", "aborted", "stopped", "complete"},
                                     state);
}

void describe(auto& form, Like<RunStanding> auto& standing) {
  form("state", one_of(standing.state, kRunStates));
  form("cause", standing.cause);
  form("time_left_s", in_seconds(standing.time_left));
  form("behind_plan_s", in_seconds(standing.behind_plan));
  form("missed_set_points", standing.missed_set_points);
  form("faults_now", standing.faults_now);
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
  state,         ///< the run's state changed, and why
  command,       ///< of an operator, with who it was
  dropped,       ///< a unit under test, by an operator
  returned,      ///< one that was dropped
  acknowledged,  ///< an alarm, with who has seen it and what they say to it
  told,          ///< of an alarm, with who was told and by which rule
};
[[nodiscard]] inline const char* name(EventKind kind) {
  return word_in<EventKind::told>(
      {"started", "resumed", "segment", "fault", "recovered", "interlock", "note", "interrupted", "finished", "state",
       "command", "dropped", "returned", "acknowledged", "told"},
      kind);
}

/// What an event is about, where it is about one thing.
struct EventSubject {
  std::string interlock{};       ///< its id
  std::string reaction{};        ///< of the interlock
  std::optional<int> segment{};  ///< of the profile, where the event belongs to a run
  std::string channel{};
};
struct Event {
  Instant at;
  EventKind kind{};
  std::string text;
  EventSubject about{};
  std::int64_t number{};  ///< in the record's table of events; 0: not in the record yet
};

}  // namespace gyrotherm
