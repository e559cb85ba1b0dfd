// SPDX-License-Identifier: Apache-2.0
/// The state machine of a run, above the profile's own machine: pure, one step per second, no clock and no I/O. The
/// terms are those of ISA-88 and PackML.
///
// clang-format off
///                       the cause is gone for a while, or an operator resumes the run
///              ┌────────────────────────┬───────────────────────────────────────────────┐
///              │                        │ set point away: by a ramp                     │
///              ▼  a cause outside       │         ▼                                     │
///   Execute ◀──────────▶ Suspended ─────┴──▶ Returning ──▶ Execute        Held ─────────┘
///      │    ──────────────────────────────────────────▶ (an operator's pause, the profile's prompt, a cause inside)
///      │ end of the profile
///      ▼             from each of them: an interlock or an operator aborts, or a state lasts too long
///   Completed        ──▶ Aborting ──▶ Aborted   (the chamber has shown the safe set point; latched)
///                    from each of them: an operator stops
///                    ──▶ Stopped, immediately or by way of Aborting, as the rig file requires
// clang-format on
///
/// The profile's clock runs only in Execute. Aborting has no time limit: the attempts continue until the chamber
/// confirms.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/run/operator_requests.hpp"

namespace gyrotherm::run {

struct Execute {};
struct Suspended {
  std::string cause;
  Duration since{};
  /// Time since the cause ended.
  Duration clear{};
  /// No fault: the run waits for a command that is being carried out, and continues immediately afterwards.
  bool waits{};
  /// Time since the profile was left, over all suspensions and returns.
  Duration away{};
};
struct Returning {
  /// Reason for leaving the profile.
  std::string cause;
  Duration since{};
  /// Time since the profile was left, over all suspensions and returns.
  Duration away{};
};
struct Held {
  std::string cause;
  Duration since{};
  /// An operator has paused the run.
  bool paused{};
};
struct Aborting {
  std::string cause;
  Duration since{};
  /// An operator's stop: ends in Stopped.
  bool stops{};
};
struct Aborted {
  std::string cause;
};
struct Stopped {
  std::string cause;
};
struct Completed {};
using RunStateMachine = std::variant<Execute, Suspended, Returning, Held, Aborting, Aborted, Stopped, Completed>;

/// Beginning of the text of the state event with which the profile continues. Reports recognise the event by it.
inline constexpr std::string_view kProfileContinues = "execute: the profile continues";

/// The inputs of one second.
struct RunInputs {
  Duration elapsed{};
  /// Reaction that the interlocks demand in this second.
  interlocks::InterlockDemand demand;
  /// The request to carry out.
  std::optional<OperatorRequest> request;
  /// Task for the operator before the profile continues; empty: none.
  std::string prompt{};
  /// Command without which the profile does not continue, while it is being carried out; empty: none.
  std::string wait{};
  /// The set point is the profile's, and the air is near it.
  bool in_place = true;
  /// The chamber has shown the safe set point, the mode and the air.
  bool safe_confirmed{};
  /// The profile has ended.
  bool complete{};
  /// The request takes the chamber over from a foreign set point.
  bool takes_over{};
  /// A stop may leave the chamber at its set point.
  bool may_be_left = true;
};

/// Returns the state one second later. The most severe event wins: abort, then stop, then hold or pause, then suspend.
[[nodiscard]] RunStateMachine next(const interlocks::RunLimits& limits, const RunStateMachine& machine,
                                   const RunInputs& inputs);

[[nodiscard]] RunState run_state(const RunStateMachine& machine);
/// Returns the reason why the run is not in Execute; empty if there is none.
[[nodiscard]] std::string state_cause(const RunStateMachine& machine);
/// Returns true if an operator has stopped the run, until and after the chamber is safe. An abort is not a stop.
[[nodiscard]] bool is_stopped_by_operator(const RunStateMachine& machine);
/// Returns true if no state follows.
[[nodiscard]] bool is_over(const RunStateMachine& machine);

/// Returns true if `to` may follow `from` within one second, by the drawing.
[[nodiscard]] bool may_follow(RunState from, RunState to);
/// Returns true if a set point may be sent in this state.
[[nodiscard]] bool may_command(RunState state);

}  // namespace gyrotherm::run
