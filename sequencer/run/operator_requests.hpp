// SPDX-License-Identifier: Apache-2.0
/// The requests of operators between two ticks, and their precedence. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/sample.hpp"
#include "sequencer/control/control_message.hpp"

namespace gyrotherm::run {

using control::OperatorCommand;

/// One operator's command.
struct OperatorRequest {
  OperatorCommand command{};
  /// The user as the control socket reports it: "ada (uid 1000)".
  std::string who;
  /// True if the request permits overwriting the set point of another program, which was active when the request was
  /// made.
  bool takes_over{};
  std::string reason{};  ///< may be empty
};

/// The requests that wait for the next tick. Only the most severe one is carried out; of several equally severe ones,
/// the first. The others are dropped.
class OperatorRequests {
 public:
  /// Returns the reason why a run in `state` would not carry out `command` at the next tick, given the waiting
  /// requests; empty if it would. An interlock may still override the command.
  [[nodiscard]] std::string refusal_reason(RunState state, OperatorCommand command) const;

  void add(OperatorRequest request) { waiting_.push_back(std::move(request)); }

  /// Returns the request that the next tick will carry out; null if none waits.
  [[nodiscard]] const OperatorRequest* find_next() const;

  /// Returns true if a waiting request ends the run.
  [[nodiscard]] bool has_end_request() const;

  struct TakenRequests {
    std::optional<OperatorRequest> carried_out;
    std::vector<OperatorRequest> dropped;
  };
  /// Removes all requests.
  [[nodiscard]] TakenRequests take();

 private:
  std::vector<OperatorRequest> waiting_;
};

}  // namespace gyrotherm::run
