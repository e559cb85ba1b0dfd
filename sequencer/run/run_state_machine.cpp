// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/run_state_machine.hpp"

#include <fmt/format.h>

#include "core/clock.hpp"

namespace gyrotherm::run {
namespace {

RunStateMachine make_timeout_abort(const char* what, Duration since, const std::string& cause) {
  return Aborting{fmt::format("{} for {}: {}", what, format_duration(since), cause), {}, false};
}

/// Returns the state in which the profile continues: Held if it has a prompt, Suspended while a command is being
/// carried out, otherwise Execute. `away` is the time since the profile was left.
RunStateMachine enter_profile(const RunInputs& now, Duration away) {
  if (!now.prompt.empty()) return Held{now.prompt, {}};
  if (!now.wait.empty()) return Suspended{.cause = now.wait, .waits = true, .away = away};
  return Execute{};
}

/// Returns the next state of a run that may resume.
RunStateMachine resume_state(const RunInputs& now, const std::string& cause, Duration away) {
  if (now.in_place) return enter_profile(now, away);
  return Returning{cause, {}, away};
}

/// Returns true if alternate suspensions and returns have lasted longer than the longest suspension and return
/// together.
bool is_away_too_long(const interlocks::RunLimits& limits, Duration away) {
  return away >= limits.longest_suspended + limits.longest_return;
}

/// Returns "stopped by ada (uid 1000): the reason".
std::string describe_end(const char* how, const OperatorRequest& request) {
  return fmt::format("{} by {}{}{}", how, request.who, request.reason.empty() ? "" : ": ", request.reason);
}

bool has_request(const RunInputs& now, OperatorCommand command) {
  return now.request && now.request->command == command;
}

/// Returns the state that an abort, a stop, a hold or a pause demands, in every state in which the profile is carried
/// out; nothing if there is no such demand.
std::optional<RunStateMachine> overriding_state(const interlocks::RunLimits& limits, const RunInputs& now, bool held) {
  if (now.demand.reaction == interlocks::Reaction::abort) return Aborting{now.demand.cause, {}, false};
  if (has_request(now, OperatorCommand::abort)) return Aborting{describe_end("aborted", *now.request), {}, false};
  if (has_request(now, OperatorCommand::stop)) {
    if (limits.on_stop == interlocks::OnStop::hold && now.may_be_left)
      return Stopped{describe_end("stopped", *now.request)};
    return Aborting{describe_end("stopped", *now.request), {}, true};
  }
  if (held) return std::nullopt;
  if (now.demand.reaction == interlocks::Reaction::hold) return Held{now.demand.cause, {}};
  if (has_request(now, OperatorCommand::pause)) return Held{"paused by " + now.request->who, {}, true};
  return std::nullopt;
}

RunStateMachine step(const interlocks::RunLimits& limits, const Execute&, const RunInputs& now) {
  if (auto other = overriding_state(limits, now, false)) return *other;
  if (!now.prompt.empty()) return Held{now.prompt, {}};
  if (now.demand.reaction == interlocks::Reaction::suspend) return Suspended{now.demand.cause, {}, {}};
  if (!now.wait.empty()) return Suspended{now.wait, {}, {}, true};
  if (now.complete) return Completed{};
  return Execute{};
}

RunStateMachine step(const interlocks::RunLimits& limits, Suspended state, const RunInputs& now) {
  if (auto other = overriding_state(limits, now, false)) return *other;
  const bool is_suspended = now.demand.reaction == interlocks::Reaction::suspend;
  state.since += now.elapsed;
  state.away += now.elapsed;
  state.clear = is_suspended ? Duration{} : state.clear + now.elapsed;
  if (is_suspended) state.cause = now.demand.cause;
  if (is_suspended) state.waits = false;
  if (state.waits && now.wait.empty()) return resume_state(now, state.cause, state.away);
  if (state.since >= limits.longest_suspended) return make_timeout_abort("suspended", state.since, state.cause);
  if (is_away_too_long(limits, state.away)) return make_timeout_abort("away from the profile", state.away, state.cause);
  const bool is_resumed = has_request(now, OperatorCommand::resume) && !is_suspended;
  const bool may_resume = is_resumed || state.clear >= limits.resume_delay;
  return may_resume && now.wait.empty() ? resume_state(now, state.cause, state.away) : state;
}

RunStateMachine step(const interlocks::RunLimits& limits, Returning state, const RunInputs& now) {
  if (auto other = overriding_state(limits, now, false)) return *other;
  state.away += now.elapsed;
  if (now.demand.reaction == interlocks::Reaction::suspend)
    return Suspended{.cause = now.demand.cause, .away = state.away};
  state.since += now.elapsed;
  if (now.in_place) return enter_profile(now, state.away);
  if (state.since >= limits.longest_return) return make_timeout_abort("returning", state.since, state.cause);
  if (is_away_too_long(limits, state.away)) return make_timeout_abort("away from the profile", state.away, state.cause);
  return state;
}

RunStateMachine step(const interlocks::RunLimits& limits, Held state, const RunInputs& now) {
  if (auto other = overriding_state(limits, now, true)) return *other;
  state.since += now.elapsed;
  if (state.since >= limits.longest_held) return make_timeout_abort("held", state.since, state.cause);
  if (!has_request(now, OperatorCommand::resume)) return state;
  if (now.takes_over) return Returning{state.cause, {}};
  if (now.demand.reaction == interlocks::Reaction::hold) return state;
  if (now.demand.reaction == interlocks::Reaction::suspend) return Suspended{now.demand.cause, {}, {}};
  return resume_state(now, state.cause, {});
}

/// Continues until the chamber has shown the safe state. An abort replaces a stop, and a stop never replaces an abort.
RunStateMachine step(const interlocks::RunLimits&, Aborting state, const RunInputs& now) {
  state.since += now.elapsed;
  if (state.stops && now.demand.reaction == interlocks::Reaction::abort) state = {now.demand.cause, state.since, false};
  if (state.stops && has_request(now, OperatorCommand::abort))
    state = {describe_end("aborted", *now.request), state.since, false};
  if (!now.safe_confirmed) return state;
  if (state.stops) return Stopped{state.cause};
  return Aborted{state.cause};
}

RunStateMachine step(const interlocks::RunLimits&, const Aborted& state, const RunInputs&) { return state; }
RunStateMachine step(const interlocks::RunLimits&, const Stopped& state, const RunInputs&) { return state; }
RunStateMachine step(const interlocks::RunLimits&, const Completed& state, const RunInputs&) { return state; }

RunState to_run_state(const Execute&) { return RunState::execute; }
RunState to_run_state(const Suspended&) { return RunState::suspended; }
RunState to_run_state(const Returning&) { return RunState::suspended; }
RunState to_run_state(const Held&) { return RunState::held; }
RunState to_run_state(const Aborting&) { return RunState::aborting; }
RunState to_run_state(const Aborted&) { return RunState::aborted; }
RunState to_run_state(const Stopped&) { return RunState::stopped; }
RunState to_run_state(const Completed&) { return RunState::complete; }

std::string cause(const Execute&) { return {}; }
std::string cause(const Completed&) { return {}; }
std::string cause(const Returning& state) { return "on the way back to the profile after: " + state.cause; }
std::string cause(const auto& state) { return state.cause; }

}  // namespace

RunStateMachine next(const interlocks::RunLimits& limits, const RunStateMachine& machine, const RunInputs& inputs) {
  return std::visit([&](const auto& state) { return step(limits, state, inputs); }, machine);
}

RunState run_state(const RunStateMachine& machine) {
  return std::visit([](const auto& state) { return to_run_state(state); }, machine);
}

std::string state_cause(const RunStateMachine& machine) {
  return std::visit([](const auto& state) { return cause(state); }, machine);
}

bool is_stopped_by_operator(const RunStateMachine& machine) {
  const auto* aborting = std::get_if<Aborting>(&machine);
  return aborting != nullptr ? aborting->stops : std::holds_alternative<Stopped>(machine);
}

bool is_over(const RunStateMachine& machine) {
  const auto state = run_state(machine);
  return state == RunState::aborted || state == RunState::stopped || state == RunState::complete;
}

bool may_follow(RunState from, RunState to) {
  if (from == to) return true;
  switch (from) {
    case RunState::execute: return to != RunState::aborted;
    case RunState::suspended:
    case RunState::held: return to != RunState::aborted && to != RunState::complete;
    case RunState::aborting: return to == RunState::aborted || to == RunState::stopped;
    case RunState::aborted:
    case RunState::stopped:
    case RunState::complete: return false;
  }
  return false;
}

bool may_command(RunState state) {
  return state == RunState::execute || state == RunState::suspended || state == RunState::held ||
         state == RunState::aborting;
}

}  // namespace gyrotherm::run
