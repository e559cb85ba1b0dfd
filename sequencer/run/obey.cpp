#include "sequencer/run/obey.hpp"

#include <fmt/format.h>

namespace gyrotherm {
namespace {

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
  if (auto why = experiment.objection(*telling.command); !why.empty()) {
    experiment.note(EventKind::command, fmt::format("{}: {}, refused: {}", who, name(*telling.command), why));
    return {.done = false, .text = std::move(why)};
  }
  experiment.tell(*telling.command, who);
  return {.done = true, .text = promise(*telling.command)};
}

}  // namespace gyrotherm
