// SPDX-License-Identifier: Apache-2.0
/// The way out of the program for text: its standard output, or its standard error. Whoever reads it may stop reading
/// (Ctrl-S, a stalled connection, a full pipe, a file on a disk that hangs), and a run that drives a chamber must not
/// wait for that.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/quantity.hpp"

namespace gyrotherm::app {

/// Calls come from one thread.
class Outlet {
 public:
  /// `descriptor` outlives it.
  explicit Outlet(int descriptor);
  /// Waits for what is still to be written, a second at most if never_wait() was called.
  ~Outlet();
  Outlet(const Outlet&) = delete;
  Outlet& operator=(const Outlet&) = delete;

  /// Until now each call waits until its text is written. From now on none does: a thread of the outlet's own writes.
  void never_wait();

  /// Whole lines, in order. Where too much waits already they are dropped, and counted: the next lines that are taken
  /// get that number.
  using Lines = std::function<std::string(std::size_t dropped)>;
  void say(const Lines& lines);
  /// Lines that are drawn in place on a terminal. One that waits is replaced: only the newest counts.
  void draw(std::vector<std::string> picture);

  /// Whether something could not be written: a full disk, a reader who has gone.
  [[nodiscard]] bool has_failed() const;

  /// Bytes that wait at most.
  static constexpr std::size_t kMostWaiting = 1 << 18;

 private:
  struct SharedState;
  std::shared_ptr<SharedState>
      desk_;  ///< shared with the thread, which may outlast the outlet if a write does not come back
  std::thread writer_;
};

class Screen {
 public:
  /// The bytes that put whole lines of text above where the picture was; the picture is gone until it is drawn again.
  [[nodiscard]] std::string message(std::string_view text);
  /// The bytes that draw these lines in the place of those drawn before; the cursor stays in the last of them.
  [[nodiscard]] std::string picture(const std::vector<std::string>& lines);

 private:
  [[nodiscard]] std::string erase();
  std::size_t lines_open_ = 0;
};

/// The first characters of a line, as many as fit: one that wraps would leave its rest on the terminal.
[[nodiscard]] std::string cut_to(const std::string& line, std::size_t width);

}  // namespace gyrotherm::app
