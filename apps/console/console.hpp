// SPDX-License-Identifier: Apache-2.0
/// Prints the output of a program: data on stdout, messages and progress on stderr.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "apps/console/outlet.hpp"
#include "apps/console/time_left.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// print_message() and print_detail() may be called from any thread. progress() and panel() have no effect on a thread
/// other than the one that made the console, because a terminal has room for one display. All other functions are
/// called from that thread.
class Console {
 public:
  Console();

  /// Data is printed as JSON. With `samples`, each sample of a run is printed, too.
  bool json = false;
  bool samples = false;
  bool quiet = false;    ///< no messages, no progress
  bool verbose = false;  ///< more messages

  /// Makes all later calls return without waiting for a slow reader of stdout or stderr. Output that exceeds the buffer
  /// is dropped. The next message or fact reports how many messages or facts were dropped before it.
  void never_wait();

  /// Prints one line on stderr unless --quiet was given. On a terminal, a line that is too long is broken at blanks.
  void print_message(std::string_view message);
  /// Prints one line of detail on stderr if --verbose was given.
  void print_detail(std::string_view message);
  /// Prints text on stdout, without characters that could control a terminal.
  void print(std::string_view text);
  /// Prints a text for a person on stdout. On a terminal, lines that are too long are broken at blanks. With --json,
  /// prints the text unchanged.
  void print_report(std::string_view text);
  /// Prints a line of data on stdout. `text` returns the line; `missed` is the number of lines that were dropped before
  /// it.
  void print_fact(const std::function<std::string(std::size_t missed)>& text);
  /// Prints a fault of the named program on stderr, in full even with --quiet.
  void print_fault(std::string_view program, const Fault& fault);

  /// Shows a stage, its percentage and the remaining time: on a terminal in one line that is redrawn, or as a plain
  /// line every 10 s if it cannot redraw. Prints nothing if stderr is not a terminal, unless --verbose was given.
  void progress(std::string_view stage, double fraction);
  /// Shows a few lines. On a terminal they are redrawn in place, at most ten times a second. Elsewhere only the first
  /// line is printed, as a plain line: once a minute, or immediately with `at_once`.
  void panel(const std::function<std::vector<std::string>()>& lines, bool at_once);
  /// Returns a sink that calls progress() and requests a stop once the user has pressed Ctrl-C.
  [[nodiscard]] ProgressSink sink();

  /// Returns true if a person can answer questions: stdin and stderr are terminals.
  [[nodiscard]] bool can_ask() const;
  /// Prints a question on stderr, even with --quiet, and waits for a line on stdin. Returns nothing at the end of the
  /// input.
  [[nodiscard]] std::optional<std::string> ask(std::string_view question);

  /// Returns true if stderr is a terminal on which panels are redrawn in place.
  [[nodiscard]] bool redraws() const { return redraws_; }
  /// Waits until all text is written; at most one second if never_wait() was called. Returns true if a write to stdout
  /// has failed.
  [[nodiscard]] bool has_lost_data() {
    out_.flush();
    return out_.has_failed();
  }

 private:
  void write_message(const std::string& message);
  void draw(std::vector<std::string> lines);
  [[nodiscard]] bool is_in_background() const { return std::this_thread::get_id() != owner_; }

  std::thread::id owner_ = std::this_thread::get_id();
  std::mutex err_guard_;
  Outlet out_, err_;
  bool redraws_;  ///< stderr is a capable terminal
  std::string stage_;
  TimeLeft time_left_;
  std::chrono::steady_clock::time_point stage_began_{}, last_shown_{};
};

}  // namespace gyrotherm::app
