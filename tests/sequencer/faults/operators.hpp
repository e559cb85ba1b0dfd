/// The operators of a simulated run: what they ask of the run, and what they were promised.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sequencer/run/run_controller.hpp"
#include "tests/sequencer/faults/schedule.hpp"

namespace gyrotherm {

inline constexpr std::int64_t kOperatorComesAfter = 60;  ///< seconds, to a run that does not go on by itself

class Operators {
 public:
  /// What a injected fault has them ask in this second, one after the other.
  void ask(const InjectedFault& fault, RunController& run_controller, std::int64_t second);
  /// One who finds the run held looks at it for a while, and lets it go on.
  void attend(RunController& run_controller, std::int64_t second);
  /// After a tick, which has to have kept what was promised: nothing, or what it did not.
  [[nodiscard]] std::optional<std::string> broken_promise(RunState state);
  /// The program that promised has died.
  void forget() { promised_.reset(); }

 private:
  void ask(OperatorCommand command, RunController& run_controller);

  std::optional<std::int64_t> resumes_at_;  ///< when the one who looks at a held run lets it go on
  std::optional<OperatorCommand> promised_;
};

}  // namespace gyrotherm
