// SPDX-License-Identifier: Apache-2.0
/// Work in a process of its own, so that whatever hangs in it hangs there alone: a line, a library, a disk.
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

/// The process that begins it must have no other threads.
class ChildWork {
 public:
  /// Tells the parent one line.
  using Tell = std::function<void(const std::string& line)>;
  /// Begins `work` in a child. If none can be made, it counts as ended without a line.
  explicit ChildWork(const std::function<void(const Tell&)>& work);

  /// The next line that it tells; nothing at its end, or when `within` is over.
  [[nodiscard]] std::optional<std::string> next(Duration within);
  /// It has told its last line. One that was killed while it hung has not.
  [[nodiscard]] bool has_ended() const { return ended_; }

 private:
  [[nodiscard]] std::optional<std::string> take_line();

  ChildProcess child_;
  std::string heard_;
  bool ended_ = false;
};

/// Says lines on standard error by a process of its own, which waits for whoever reads them; what it cannot take is not
/// said.
class Voice {
 public:
  Voice();
  /// Waits a second at most until all is said.
  ~Voice();
  Voice(const Voice&) = delete;
  Voice& operator=(const Voice&) = delete;

  void say(const std::string& line);

 private:
  pid_t pid_ = -1;
  Descriptor mouth_;
};

}  // namespace gyrotherm::watchdog
