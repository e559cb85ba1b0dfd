// SPDX-License-Identifier: Apache-2.0
/// The gyrotherm program run as a child process, in a folder of its own.
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
  std::string out;  ///< stdout
  std::string err;  ///< stderr
};

/// A folder that goes when the test ends.
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

/// Runs a command line in a shell, from the project's root. "gyrotherm" in it is the program under test.
Ran shell(const std::string& command, const std::string& input = "");
/// Runs gyrotherm with these arguments.
Ran gyrotherm_with(const std::string& arguments, const std::string& input = "");

/// A gyrotherm that goes on in the background until told.
class Background {
 public:
  Background(const std::vector<std::string>& arguments, const std::string& output_file);
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  void signal(int number) const;
  /// Waits for its end; its exit code, or −signal.
  int wait();
  [[nodiscard]] bool is_running() const;
  /// Of the running program, all its threads; zero once it has ended.
  [[nodiscard]] std::chrono::nanoseconds processor_time() const;
  /// What it has printed so far.
  [[nodiscard]] std::string output() const;
  /// Waits until it has printed `text`. Returns false after `seconds`, or if the program has ended without it.
  [[nodiscard]] bool wait_for(const std::string& text, int seconds) const;

 private:
  pid_t pid_ = -1;
  std::string output_file_;
};

/// The last second that the program said, in its --json output, that it had acknowledged; −1 if none.
std::int64_t last_acknowledged(const std::string& output);

/// Returns the options that a text names, each as "--out".
std::set<std::string> options_in(const std::string& text);

/// True if a program of this name is on the PATH.
bool installed(const std::string& program);

/// The folder of real recordings and schemas, from GYROTHERM_SHARED; "" if it is not set.
std::string shared_folder();

}  // namespace gyrotherm::app
