// SPDX-License-Identifier: Apache-2.0
/// What operators ask of a run between two ticks, and what comes of it. Pure.
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
  std::string who;       ///< as the control socket says: "ada (uid 1000)"
  bool takes_over{};     ///< it ends what somebody else's set point holds, which stood already when it was made
  std::string reason{};  ///< reason given; may be empty
};

/// The requests that wait for the next tick. The most severe of them is carried out, of equally severe ones the first;
/// the others are dropped, and their operators have been told so unless a more severe request came after theirs.
class OperatorRequests {
 public:
  /// Why a run in `state` would not do what `command` asks at the next tick, given the requests that wait; empty if it
  /// will. Interlocks may still do more than any operator asks.
  [[nodiscard]] std::string objection(RunState state, OperatorCommand command) const;

  void add(OperatorRequest request) { waiting_.push_back(std::move(request)); }

  /// The request that the next tick will carry out; null if none waits.
  [[nodiscard]] const OperatorRequest* foremost() const;

  /// Whether one waits that ends the run.
  [[nodiscard]] bool end_the_run() const;

  struct Taken {
    std::optional<OperatorRequest> carried_out;
    std::vector<OperatorRequest> dropped;
  };
  /// Ends the wait of all of them.
  [[nodiscard]] Taken take();

 private:
  std::vector<OperatorRequest> waiting_;
};

}  // namespace gyrotherm::run
