#include "tests/sequencer/faults/operators.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tests/sequencer/faults/laws.hpp"

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
void Operators::ask(OperatorCommand command, Experiment& experiment) {
  if (!experiment.objection(command).empty()) return;
  experiment.tell(command, "operator");
  promised_ = std::max(promised_.value_or(command), command);
}

void Operators::ask(const Mishap& mishap, Experiment& experiment, std::int64_t second) {
  constexpr int kCommands = 4;
  switch (mishap.kind) {
    case MishapKind::operator_pauses:
      resumes_at_ = second + mishap.lasts;
      return ask(OperatorCommand::pause, experiment);
    case MishapKind::operator_stops: return ask(OperatorCommand::stop, experiment);
    case MishapKind::operator_aborts: return ask(OperatorCommand::abort, experiment);
    case MishapKind::operators_at_once:
      for (int which = static_cast<int>(mishap.size); which > 0; which /= kCommands)
        ask(static_cast<OperatorCommand>(which % kCommands), experiment);
      return;
    default: return;
  }
}

void Operators::attend(Experiment& experiment, std::int64_t second) {
  if (experiment.run_state() != RunState::held) {
    resumes_at_.reset();
    return;
  }
  if (!resumes_at_) resumes_at_ = second + kOperatorComesAfter;
  if (second < *resumes_at_) return;
  ask(OperatorCommand::resume, experiment);
  resumes_at_ = second + kOperatorComesAfter;
}

std::optional<std::string> Operators::broken_promise(RunState state) {
  const auto promised = std::exchange(promised_, std::nullopt);
  if (!promised || severity(state) >= least_severity(*promised)) return {};
  return fmt::format("{} was promised, and the run is in state {}", name(*promised), name(state));
}

}  // namespace gyrotherm
