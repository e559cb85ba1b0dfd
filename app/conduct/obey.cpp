#include "app/conduct/obey.hpp"

#include <fmt/format.h>

namespace gyrotherm {
namespace {

/// Why this state does not allow the command; empty if it does.
std::string objection(const Experiment& experiment, OperatorCommand command) {
  const auto state = experiment.run_state();
  if (state == RunState::aborting && command != OperatorCommand::abort) return "the chamber is being made safe";
  if (state > RunState::aborting) return fmt::format("the run is over: {}", name(state));
  if (command == OperatorCommand::resume && state != RunState::held)
    return fmt::format("the run is not held: {}", name(state));
  if (command != OperatorCommand::pause) return {};
  if (state == RunState::held) return "the run is held already";
  return experiment.is_left_to_the_controller() ? "the controller carries the profile out; only its panel can pause it"
                                                : "";
}

const char* promise(OperatorCommand command) {
  switch (command) {
    case OperatorCommand::pause: return "held: the profile's clock stands and the set point stays, until resume";
    case OperatorCommand::resume: return "goes on";
    case OperatorCommand::stop: return "stops: the chamber is left as the rig file says";
    case OperatorCommand::abort: return "aborts: the chamber is made safe";
  }
  return "";
}

}  // namespace

TellAnswer obey(Experiment& experiment, const Telling& telling, const std::string& who) {
  if (!telling.command) {
    experiment.note(EventKind::note, who + ": " + telling.note);
    return {.done = true, .text = "noted"};
  }
  if (auto why = objection(experiment, *telling.command); !why.empty()) {
    experiment.note(EventKind::command, fmt::format("{}: {}, refused: {}", who, name(*telling.command), why));
    return {.done = false, .text = std::move(why)};
  }
  experiment.tell(*telling.command, who);
  return {.done = true, .text = promise(*telling.command)};
}

}  // namespace gyrotherm
