// SPDX-License-Identifier: Apache-2.0
/// Runs work in a separate process. A hang of a line, a library or a disk then affects only that process.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>

#include "core/child_process.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::watchdog {

/// Runs work in a child process. The parent must have no other threads.
class ChildWork {
 public:
  /// Sends one line to the parent.
  using SendLine = std::function<void(const std::string& line)>;
  /// Begins `work` in a child process. If the process cannot be started, has_ended() returns true and no line follows.
  explicit ChildWork(const std::function<void(const SendLine&)>& work);

  /// Returns the next line that the work sends. Returns nothing at its end, or after `within`.
  [[nodiscard]] std::optional<std::string> next(Duration within);
  /// Returns true if the work has sent its last line, and false if it was killed during a hang.
  [[nodiscard]] bool has_ended() const { return ended_; }

 private:
  [[nodiscard]] std::optional<std::string> take_line();

  ChildProcess child_;
  std::string received_;
  bool ended_ = false;
};

/// Prints lines on standard error from a separate process, which waits for a slow reader. Drops lines that the process
/// cannot accept.
class ErrorPrinter {
 public:
  ErrorPrinter();
  /// Waits at most one second until all lines are printed.
  ~ErrorPrinter();
  ErrorPrinter(const ErrorPrinter&) = delete;
  ErrorPrinter& operator=(const ErrorPrinter&) = delete;

  void print(const std::string& line);

 private:
  pid_t pid_ = -1;
  Descriptor pipe_;
};

}  // namespace gyrotherm::watchdog
