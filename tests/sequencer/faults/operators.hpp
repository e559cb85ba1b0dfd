// SPDX-License-Identifier: Apache-2.0
/// The operators of a simulated run: what they ask of the run, and what they were promised.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/outlet.hpp"
#include "core/file.hpp"
#include "sequencer/run/run_controller.hpp"
#include "tests/sequencer/faults/schedule.hpp"

namespace gyrotherm::faults {

inline constexpr std::int64_t kOperatorComesAfter = 60;  ///< seconds, to a run that does not go on by itself

class Operators {
 public:
  /// What a injected fault has them ask in this second, one after the other.
  void ask(const InjectedFault& fault, run::RunController& run_controller, std::int64_t second);
  /// One who finds the run held looks at it for a while, and lets it go on.
  void attend(run::RunController& run_controller, std::int64_t second);
  /// After a tick, which has to have kept what was promised: nothing, or what it did not.
  [[nodiscard]] std::optional<std::string> broken_promise(RunState state);
  /// The program that promised has died.
  void forget() { promised_.reset(); }
  /// Drops a unit, or keeps it dropped, until `lasts` seconds from now.
  void drop(const std::string& unit, std::int64_t lasts, run::RunController& run_controller, std::int64_t second);
  [[nodiscard]] bool has_dropped(const std::string& unit) const;

 private:
  void ask(control::OperatorCommand command, run::RunController& run_controller);

  /// Units that are dropped, each with the second in which it is returned.
  std::vector<std::pair<std::string, std::int64_t>> returns_at_;
  std::optional<std::int64_t> resumes_at_;  ///< when the one who looks at a held run lets it go on
  std::optional<control::OperatorCommand> promised_;
};

// Who reads what a program says, or does not: a pipe behind the program's own outlet.

class Listener {
 public:
  Listener();

  /// The program says what it says in one second: a message, which is long, and a picture.
  void hear();
  /// Takes what has come.
  void read();
  /// At the end: nothing, or which message was lost without a word.
  [[nodiscard]] std::optional<std::string> missing();

 private:
  void take(const char* bytes, std::size_t size);
  bool read_within(int milliseconds);

  Descriptor reader_, writer_;
  std::unique_ptr<app::Outlet> outlet_;
  std::int64_t said_ = 0, heard_ = 0;  ///< the number of the last message
  std::string number_;                 ///< of the message that is being read, as far as it has come
  bool in_number_ = false;
  std::optional<std::string> missing_;
};

}  // namespace gyrotherm::faults
