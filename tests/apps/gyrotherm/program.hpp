// SPDX-License-Identifier: Apache-2.0
/// Child process that runs gyrotherm in a folder of its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace gyrotherm::app {

struct Ran {
  int exit_code{};
  std::string out;
  std::string err;
};

/// Folder that is removed at the end of the test.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// Runs a command line in a shell, in the root folder of the project. "gyrotherm" is the program under test.
Ran shell(const std::string& command, const std::string& input = "");
/// Runs gyrotherm with these arguments.
Ran gyrotherm_with(const std::string& arguments, const std::string& input = "");

/// Runs gyrotherm on a terminal of its own, on which `input` is typed. Returns its output. Presses Ctrl-C once the
/// output contains `interrupt_at`, unless that is empty.
Ran run_on_terminal(const std::vector<std::string>& arguments, const std::string& input,
                    const std::string& interrupt_at = "");

/// gyrotherm in the background, until it ends or is killed.
class Background {
 public:
  Background(const std::vector<std::string>& arguments, const std::string& output_file);
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  void signal(int number) const;
  /// Waits for the end. Returns the exit code, or −signal.
  int wait();
  [[nodiscard]] bool is_running() const;
  /// Returns the processor time of all threads, or zero after the end.
  [[nodiscard]] std::chrono::nanoseconds processor_time() const;
  /// Returns the output so far.
  [[nodiscard]] std::string output() const;
  /// Waits until it has printed `text`. Returns false after `seconds`, or if the program has ended without it.
  [[nodiscard]] bool wait_for(const std::string& text, int seconds) const;

 private:
  pid_t pid_ = -1;
  std::string output_file_;
};

/// Returns the last second that the --json output acknowledges, or −1.
std::int64_t last_acknowledged(const std::string& output);

/// Returns the options that a text names, each as "--out".
std::set<std::string> options_in(const std::string& text);

/// Returns whether a program of this name is on the PATH.
bool installed(const std::string& program);

/// Returns the folder of real recordings and schemas, GYROTHERM_SHARED, or "" if it is not set.
std::string shared_folder();

}  // namespace gyrotherm::app
