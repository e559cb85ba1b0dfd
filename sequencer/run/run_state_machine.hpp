// SPDX-License-Identifier: Apache-2.0
/// How a run is carried out, above the profile's own machine: pure, one step per second, no clock and no I/O. The words
/// are those of ISA-88 and PackML.
///
// clang-format off
///                       the cause is gone for a while, or an operator says resume
///              ┌────────────────────────┬───────────────────────────────────────────────┐
///              │                        │ set point away: by a ramp                     │
///              ▼  a cause outside       │         ▼                                     │
///   Execute ◀──────────▶ Suspended ─────┴──▶ Returning ──▶ Execute        Held ─────────┘
///      │    ──────────────────────────────────────────▶ (an operator's pause, the profile's prompt, a cause inside)
///      │ end of the profile
///      ▼             from each of them: an interlock or an operator aborts, or a state lasts too long
///   Completed        ──▶ Aborting ──▶ Aborted   (the chamber has shown the safe set point; latched)
///                    from each of them: an operator stops
///                    ──▶ Stopped, at once or by way of Aborting, as the rig says
// clang-format on
///
/// The profile's clock runs in Execute alone. Aborting has no limit: it is tried until the chamber confirms.
#pragma once

#include <optional>
#include <string>
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
  Duration clear{};  ///< how long the cause has been gone
};
struct Returning {
  std::string cause;  ///< why it had left the profile
  Duration since{};
};
struct Held {
  std::string cause;
  Duration since{};
};
struct Aborting {
  std::string cause;
  Duration since{};
  bool stops{};  ///< an operator's stop: ends in Stopped
};
struct Aborted {
  std::string cause;
};
struct Stopped {
  std::string cause;
};
struct Completed {};
using RunStateMachine = std::variant<Execute, Suspended, Returning, Held, Aborting, Aborted, Stopped, Completed>;

/// What a second brought.
struct RunInputs {
  Duration elapsed{};
  interlocks::InterlockDemand demand;      ///< what the interlocks demand
  std::optional<OperatorRequest> request;  ///< the one that is carried out
  std::string prompt{};                    ///< what the profile asks of people before it goes on; empty: nothing
  bool in_place = true;                    ///< the set point is the profile's, and the air is near it
  bool safe_confirmed{};                   ///< set point, mode and air are shown
  bool complete{};                         ///< the profile has come to its end
  bool takes_over{};                       ///< the request ends what holds the run: somebody else's set point
  bool may_be_left = true;                 ///< a stop may leave the chamber at its set point, which it holds
};

/// The state one second later. The most severe of what happened wins: abort, then stop, then hold or pause, then
/// suspend.
[[nodiscard]] RunStateMachine next(const interlocks::RunLimits& limits, const RunStateMachine& machine,
                                   const RunInputs& inputs);

[[nodiscard]] RunState run_state(const RunStateMachine& machine);
/// Why it is not in Execute; empty where there is nothing to say.
[[nodiscard]] std::string cause_of(const RunStateMachine& machine);
/// Whether a run goes on after this state.
[[nodiscard]] bool is_over(const RunStateMachine& machine);

/// The table of the drawing: whether `to` may follow `from` within one second.
[[nodiscard]] bool may_follow(RunState from, RunState to);
/// Whether a set point may be sent in this state.
[[nodiscard]] bool may_command(RunState state);

}  // namespace gyrotherm::run
