// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/operator_requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace gyrotherm::run {
namespace {

bool is_milder(const OperatorRequest& a, const OperatorRequest& b) { return a.command < b.command; }

/// Returns the reason why the state forbids the command; empty if it does not.
std::string state_refusal_reason(RunState state, OperatorCommand command) {
  if (state == RunState::aborting && command != OperatorCommand::abort) return "the chamber is being made safe";
  if (state > RunState::aborting) return fmt::format("the run is over: {}", name(state));
  if (command == OperatorCommand::resume && state != RunState::held)
    return fmt::format("the run is not held: {}", name(state));
  if (command == OperatorCommand::pause && state == RunState::held) return "the run is held already";
  return {};
}

}  // namespace

std::string OperatorRequests::refusal_reason(RunState state, OperatorCommand command) const {
  const auto* first = find_next();
  if (first && first->command > command)
    return fmt::format("{} by {} has priority in the same second", name(first->command), first->who);
  const bool keeps_held = command == OperatorCommand::pause && first && first->command == OperatorCommand::resume;
  return keeps_held ? std::string() : state_refusal_reason(state, command);
}

const OperatorRequest* OperatorRequests::find_next() const {
  const auto most = std::max_element(waiting_.begin(), waiting_.end(), is_milder);
  return most == waiting_.end() ? nullptr : &*most;
}

bool OperatorRequests::has_end_request() const {
  const auto* first = find_next();
  return first && first->command >= OperatorCommand::stop;
}

OperatorRequests::TakenRequests OperatorRequests::take() {
  TakenRequests taken;
  const auto* first = find_next();
  for (auto& request : waiting_)
    if (&request == first)
      taken.carried_out = std::move(request);
    else
      taken.dropped.push_back(std::move(request));
  waiting_.clear();
  return taken;
}

}  // namespace gyrotherm::run
