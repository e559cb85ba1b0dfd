/// How the program speaks: data on stdout, messages and progress on stderr.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/progress.hpp"
#include "core/result.hpp"

namespace gyrotherm {

class Console {
 public:
  Console();

  bool json = false;     ///< facts as JSON
  bool quiet = false;    ///< no messages, no progress
  bool verbose = false;  ///< more of them

  /// One line for people, on stderr.
  void say(std::string_view message);
  /// One line of more detail, with --verbose.
  void detail(std::string_view message);
  /// Data, on stdout, as it is; flushed. Whether all of it could be written is for main to ask at the end.
  void data(std::string_view text);
  /// A fault, on stderr, whole even with --quiet.
  void complain(const Fault& fault);

  /// Shows a stage, its percentage and the time left: on a terminal one moving line, elsewhere a plain line now and
  /// then.
  void progress(std::string_view stage, double fraction);
  /// Shows a few lines, redrawn in place on a terminal at most ten times a second; elsewhere the first of them as a
  /// plain line now and then, and where `at_once`.
  void panel(const std::function<std::vector<std::string>()>& lines, bool at_once);
  /// progress() as a sink that also asks for a stop once the user has pressed Ctrl-C.
  [[nodiscard]] ProgressSink sink();

 private:
  void clear_line();
  bool moving_;  ///< stderr is a terminal and may be redrawn
  std::string stage_;
  std::chrono::steady_clock::time_point stage_began_{}, last_shown_{};
  int lines_open_ = 0;  ///< of a moving line or panel, the cursor in the last of them
};

}  // namespace gyrotherm
