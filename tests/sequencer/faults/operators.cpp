#include "tests/sequencer/faults/operators.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tests/sequencer/faults/invariants.hpp"

namespace gyrotherm {
namespace {

/// How severe a state is at least, once a command was carried out.
int least_severity(OperatorCommand command) {
  switch (command) {
    case OperatorCommand::resume: return severity(RunState::execute);
    case OperatorCommand::pause: return severity(RunState::held);
    case OperatorCommand::stop:
    case OperatorCommand::abort: return severity(RunState::aborting);
  }
  return 0;
}

}  // namespace

/// What is not refused is promised. Of several promises the most severe is to be kept.
void Operators::ask(OperatorCommand command, RunController& run_controller) {
  if (!run_controller.objection(command).empty()) return;
  run_controller.tell(command, "operator");
  promised_ = std::max(promised_.value_or(command), command);
}

void Operators::ask(const InjectedFault& fault, RunController& run_controller, std::int64_t second) {
  constexpr int kCommands = 4;
  switch (fault.kind) {
    case InjectedFaultKind::operator_pauses:
      resumes_at_ = second + fault.lasts;
      return ask(OperatorCommand::pause, run_controller);
    case InjectedFaultKind::operator_stops: return ask(OperatorCommand::stop, run_controller);
    case InjectedFaultKind::operator_aborts: return ask(OperatorCommand::abort, run_controller);
    case InjectedFaultKind::operators_at_once:
      for (int which = static_cast<int>(fault.size); which > 0; which /= kCommands)
        ask(static_cast<OperatorCommand>(which % kCommands), run_controller);
      return;
    default: return;
  }
}

void Operators::attend(RunController& run_controller, std::int64_t second) {
  if (run_controller.run_state() != RunState::held) {
    resumes_at_.reset();
    return;
  }
  if (!resumes_at_) resumes_at_ = second + kOperatorComesAfter;
  if (second < *resumes_at_) return;
  ask(OperatorCommand::resume, run_controller);
  resumes_at_ = second + kOperatorComesAfter;
}

std::optional<std::string> Operators::broken_promise(RunState state) {
  const auto promised = std::exchange(promised_, std::nullopt);
  if (!promised || severity(state) >= least_severity(*promised)) return {};
  return fmt::format("{} was promised, and the run is in state {}", name(*promised), name(state));
}

}  // namespace gyrotherm
