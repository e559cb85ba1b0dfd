// SPDX-License-Identifier: Apache-2.0
/// Operators of a simulated run: their requests, and the promises that the run must keep.
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

/// Delay, in seconds, after which an operator resumes a run that does not resume by itself.
inline constexpr std::int64_t kOperatorComesAfter = 60;

class Operators {
 public:
  /// Makes the requests of a fault in this second, one after the other.
  void submit(const InjectedFault& fault, run::RunController& run_controller, std::int64_t second);
  /// Resumes a held run after a while.
  void resume_after_wait(run::RunController& run_controller, std::int64_t second);
  /// Returns the promise that the last tick did not keep, or nothing.
  [[nodiscard]] std::optional<std::string> broken_promise(RunState state);
  /// Discards the promises of a program that has died.
  void forget() { promised_.reset(); }
  /// Drops a unit, or keeps it dropped, until `lasts` seconds from now.
  void drop(const std::string& unit, std::int64_t lasts, run::RunController& run_controller, std::int64_t second);
  [[nodiscard]] bool has_dropped(const std::string& unit) const;

 private:
  void submit(control::OperatorCommand command, run::RunController& run_controller);

  /// Dropped units, each with the second of its return.
  std::vector<std::pair<std::string, std::int64_t>> returns_at_;
  /// Second in which a held run is resumed.
  std::optional<std::int64_t> resumes_at_;
  std::optional<control::OperatorCommand> promised_;
};

// Reader of the program's messages at the end of a pipe. It may stop reading. The messages are written through the
// program's own class Outlet.

class Listener {
 public:
  Listener();

  /// Writes the output of one second: a long message and a display.
  void write_second();
  /// Reads the pending output.
  void read();
  /// Describes the first message that was lost without a report; nothing if there is none. Call it at the end.
  [[nodiscard]] std::optional<std::string> first_lost_message();

 private:
  void take(const char* bytes, std::size_t size);
  bool wait_for_output(int milliseconds);

  Descriptor reader_, writer_;
  std::unique_ptr<app::Outlet> outlet_;
  /// Numbers of the last written and the last read message.
  std::int64_t last_written_ = 0, last_read_ = 0;
  /// Digits of the current message so far.
  std::string number_;
  bool in_number_ = false;
  std::optional<std::string> missing_;
};

}  // namespace gyrotherm::faults
