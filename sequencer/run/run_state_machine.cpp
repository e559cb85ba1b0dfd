#include "sequencer/run/run_state_machine.hpp"

#include <fmt/format.h>

#include "core/clock.hpp"

namespace gyrotherm {
namespace {

Procedure too_long(const char* what, Duration since, const std::string& cause) {
  return Aborting{fmt::format("{} for {}: {}", what, spoken(since), cause), {}, false};
}

/// Where a run goes that may go on.
Procedure onwards(const Happening& now, const std::string& cause) {
  if (now.in_place) return Execute{};
  return Returning{cause, {}};
}

bool asks_for(const Happening& now, OperatorCommand command) { return now.request && now.request->command == command; }

/// What outranks the profile in every state in which it is still being carried out.
std::optional<Procedure> overruled(const ProcedureLimits& limits, const Happening& now, bool held) {
  if (now.verdict.reaction == Reaction::abort) return Aborting{now.verdict.cause, {}, false};
  if (asks_for(now, OperatorCommand::abort)) return Aborting{"aborted by " + now.request->who, {}, false};
  if (asks_for(now, OperatorCommand::stop)) {
    if (limits.on_stop == OnStop::hold) return Stopped{"stopped by " + now.request->who};
    return Aborting{"stopped by " + now.request->who, {}, true};
  }
  if (held) return std::nullopt;
  if (now.verdict.reaction == Reaction::hold) return Held{now.verdict.cause, {}};
  if (asks_for(now, OperatorCommand::pause)) return Held{"paused by " + now.request->who, {}};
  return std::nullopt;
}

Procedure step(const ProcedureLimits& limits, const Execute&, const Happening& now) {
  if (auto other = overruled(limits, now, false)) return *other;
  if (now.verdict.reaction == Reaction::suspend) return Suspended{now.verdict.cause, {}, {}};
  if (now.complete) return Completed{};
  return Execute{};
}

Procedure step(const ProcedureLimits& limits, Suspended state, const Happening& now) {
  if (auto other = overruled(limits, now, false)) return *other;
  const bool stands = now.verdict.reaction == Reaction::suspend;
  state.since += now.elapsed;
  state.clear = stands ? Duration{} : state.clear + now.elapsed;
  if (stands) state.cause = now.verdict.cause;
  if (state.since >= limits.longest_suspended) return too_long("suspended", state.since, state.cause);
  const bool asked = asks_for(now, OperatorCommand::resume) && !stands;
  return asked || state.clear >= limits.resume_delay ? onwards(now, state.cause) : state;
}

Procedure step(const ProcedureLimits& limits, Returning state, const Happening& now) {
  if (auto other = overruled(limits, now, false)) return *other;
  if (now.verdict.reaction == Reaction::suspend) return Suspended{now.verdict.cause, {}, {}};
  state.since += now.elapsed;
  if (now.in_place) return Execute{};
  if (state.since >= limits.longest_return) return too_long("returning", state.since, state.cause);
  return state;
}

Procedure step(const ProcedureLimits& limits, Held state, const Happening& now) {
  if (auto other = overruled(limits, now, true)) return *other;
  state.since += now.elapsed;
  if (state.since >= limits.longest_held) return too_long("held", state.since, state.cause);
  if (!asks_for(now, OperatorCommand::resume) || now.verdict.reaction == Reaction::hold) return state;
  if (now.verdict.reaction == Reaction::suspend) return Suspended{now.verdict.cause, {}, {}};
  return onwards(now, state.cause);
}

/// A stop that becomes an abort stays one.
Procedure step(const ProcedureLimits&, Aborting state, const Happening& now) {
  state.since += now.elapsed;
  if (state.stops && now.verdict.reaction == Reaction::abort) state = {now.verdict.cause, state.since, false};
  if (state.stops && asks_for(now, OperatorCommand::abort))
    state = {"aborted by " + now.request->who, state.since, false};
  if (!now.safe_confirmed) return state;
  if (state.stops) return Stopped{state.cause};
  return Aborted{state.cause};
}

Procedure step(const ProcedureLimits&, const Aborted& state, const Happening&) { return state; }
Procedure step(const ProcedureLimits&, const Stopped& state, const Happening&) { return state; }
Procedure step(const ProcedureLimits&, const Completed& state, const Happening&) { return state; }

RunState word(const Execute&) { return RunState::execute; }
RunState word(const Suspended&) { return RunState::suspended; }
RunState word(const Returning&) { return RunState::suspended; }
RunState word(const Held&) { return RunState::held; }
RunState word(const Aborting&) { return RunState::aborting; }
RunState word(const Aborted&) { return RunState::aborted; }
RunState word(const Stopped&) { return RunState::stopped; }
RunState word(const Completed&) { return RunState::complete; }

std::string cause(const Execute&) { return {}; }
std::string cause(const Completed&) { return {}; }
std::string cause(const Returning& state) { return "on the way back to the profile after: " + state.cause; }
std::string cause(const auto& state) { return state.cause; }

}  // namespace

Procedure next(const ProcedureLimits& limits, const Procedure& procedure, const Happening& happening) {
  return std::visit([&](const auto& state) { return step(limits, state, happening); }, procedure);
}

RunState run_state(const Procedure& procedure) {
  return std::visit([](const auto& state) { return word(state); }, procedure);
}

std::string cause_of(const Procedure& procedure) {
  return std::visit([](const auto& state) { return cause(state); }, procedure);
}

bool is_over(const Procedure& procedure) {
  const auto state = run_state(procedure);
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

}  // namespace gyrotherm
