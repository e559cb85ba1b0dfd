// SPDX-License-Identifier: Apache-2.0
/// Writes to standard output or standard error. A write may block (Ctrl-S, a stalled connection, a full pipe, a file on
/// a disk that hangs). A run that drives a chamber must not wait for it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/quantity.hpp"

namespace gyrotherm::app {

/// All functions are called from one thread.
class Outlet {
 public:
  /// `descriptor` must outlive the object.
  explicit Outlet(int descriptor);
  /// Waits until all text is written; at most one second if never_wait() was called.
  ~Outlet();
  Outlet(const Outlet&) = delete;
  Outlet& operator=(const Outlet&) = delete;

  /// Starts a writer thread, so all later calls return immediately. Without the thread, each call waits until its text
  /// is written.
  void never_wait();

  /// Writes the lines that `lines` returns. If more than kMaxWaitingBytes bytes would wait, drops them. `dropped` is
  /// the number of calls that were dropped since the last accepted one.
  using Lines = std::function<std::string(std::size_t dropped)>;
  void write_lines(const Lines& lines);
  /// Draws lines on a terminal in place of the previous ones. If those have not been written yet, they are skipped.
  void draw(std::vector<std::string> picture);

  /// Waits until all text is written; at most one second if never_wait() was called. Returns true if it is written.
  bool flush();
  /// Returns true if a write has failed, for example on a full disk or a closed pipe.
  [[nodiscard]] bool has_failed() const;

  /// Largest number of bytes that wait to be written.
  static constexpr std::size_t kMaxWaitingBytes = 1 << 18;

 private:
  struct SharedState;
  /// Shared with the thread, which may outlive the object if a write hangs.
  std::shared_ptr<SharedState> state_;
  std::thread writer_;
};

/// Tracks the lines that were drawn in place, and generates the terminal output that replaces them.
class Screen {
 public:
  /// Returns the bytes that erase the picture and print whole lines of text in its place. The next picture() draws the
  /// picture below them.
  [[nodiscard]] std::string message(std::string_view text);
  /// Returns the bytes that replace the previous picture by these lines. The cursor remains in the last line.
  [[nodiscard]] std::string picture(const std::vector<std::string>& lines);

 private:
  [[nodiscard]] std::string erase();
  /// Number of lines of the picture on the terminal.
  std::size_t lines_open_ = 0;
};

/// Shortens a line to `width` characters, because a line that wraps cannot be erased completely.
[[nodiscard]] std::string truncate_line(const std::string& line, std::size_t width);

/// Breaks each line that is longer than `width` characters at blanks. The parts after the first one are indented by two
/// characters more than the line. A word that is longer than a line is not broken.
[[nodiscard]] std::string wrap_lines(std::string_view text, std::size_t width);

}  // namespace gyrotherm::app
