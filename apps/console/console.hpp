// SPDX-License-Identifier: Apache-2.0
/// How the program speaks: data on stdout, messages and progress on stderr.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/console/outlet.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// All calls come from the main thread.
class Console {
 public:
  Console();

  bool json = false;     ///< facts as JSON
  bool samples = false;  ///< … and each second of a run
  bool quiet = false;    ///< no messages, no progress
  bool verbose = false;  ///< more of them

  /// From now on no call waits for whoever reads stdout or stderr. What cannot be shown in time is dropped, pictures
  /// first; of messages and of facts the next ones say how many were.
  void never_wait();

  /// One line for people, on stderr.
  void say(std::string_view message);
  /// One line of more detail, with --verbose.
  void detail(std::string_view message);
  /// Data, on stdout: text, without what could steer a terminal.
  void data(std::string_view text);
  /// One line of data; `text` is told how many such lines before it were dropped since the last one was not.
  void fact(const std::function<std::string(std::size_t missed)>& text);
  /// A fault of the program of that name, on stderr, whole even with --quiet.
  void complain(std::string_view program, const Fault& fault);

  /// Shows a stage, its percentage and the time left: on a terminal one moving line, elsewhere a plain line now and
  /// then.
  void progress(std::string_view stage, double fraction);
  /// Shows a few lines, redrawn in place on a terminal at most ten times a second; elsewhere the first of them as a
  /// plain line now and then, and where `at_once`.
  void panel(const std::function<std::vector<std::string>()>& lines, bool at_once);
  /// progress() as a sink that also asks for a stop once the user has pressed Ctrl-C.
  [[nodiscard]] ProgressSink sink();

  /// Whether a panel is redrawn in place.
  [[nodiscard]] bool redraws() const { return moving_; }
  /// Whether some data could not be written.
  [[nodiscard]] bool data_was_lost() const { return out_.has_failed(); }

 private:
  void put_message(std::string words);

  Outlet out_, err_;
  bool moving_;  ///< stderr is a terminal and may be redrawn
  std::string stage_;
  std::chrono::steady_clock::time_point stage_began_{}, last_shown_{};
};

}  // namespace gyrotherm::app
