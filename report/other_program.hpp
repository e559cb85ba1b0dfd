// SPDX-License-Identifier: Apache-2.0
/// Another program run as a child process: what signs and verifies is not ours.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::report {

struct ProgramRun {
  int exit_code{};
  std::string out{};  ///< what it wrote on stdout and on stderr, as it came
};

/// Runs a program of the PATH to its end, in English, with nothing on its stdin; its words are no shell's. Fails with
/// bad_file naming the Debian package if the program is not installed, with timeout if it does not end in time, and
/// with refused if a signal ended it.
[[nodiscard]] Result<ProgramRun> run_program(const std::string& program, const std::vector<std::string>& words,
                                             std::chrono::milliseconds longest = std::chrono::seconds(60));

/// A folder that nobody else can look into, and that goes with its owner: for keys. It is in the memory of the machine
/// where the system has such a place for the user (XDG_RUNTIME_DIR), else among its temporary files.
class PrivateFolder {
 public:
  /// Fails with storage.
  [[nodiscard]] static Result<PrivateFolder> make();
  ~PrivateFolder();
  PrivateFolder(PrivateFolder&& other) noexcept : path_(std::move(other.path_)) { other.path_.clear(); }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(PrivateFolder&&) = delete;

  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  explicit PrivateFolder(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace gyrotherm::report
