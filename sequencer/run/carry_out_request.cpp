#include "sequencer/run/carry_out_request.hpp"

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

ControlAnswer carry_out(RunController& run_controller, const ControlRequest& request, const std::string& who) {
  if (!request.command) {
    run_controller.note(EventKind::note, who + ": " + request.note);
    return {.done = true, .text = "noted"};
  }
  if (auto why = run_controller.objection(*request.command); !why.empty()) {
    run_controller.note(EventKind::command, fmt::format("{}: {}, refused: {}", who, name(*request.command), why));
    return {.done = false, .text = std::move(why)};
  }
  run_controller.tell(*request.command, who);
  return {.done = true, .text = promise(*request.command)};
}

}  // namespace gyrotherm
