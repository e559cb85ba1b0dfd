// SPDX-License-Identifier: Apache-2.0
/// Runs third-party programs that create or verify the signatures of reports, as child processes.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::report {

struct ProgramRun {
  int exit_code{};
  std::string out{};  ///< stdout and stderr, in order
};

/// Runs a program of the PATH to its end, in English, in UTC and with an empty stdin. No shell interprets `arguments`.
/// Fails with bad_file and the name of the Debian package if the program is not installed, with timeout if it does not
/// end in time, and with refused if a signal ended it.
[[nodiscard]] Result<ProgramRun> run_program(const std::string& program, const std::vector<std::string>& arguments,
                                             std::chrono::milliseconds longest = std::chrono::seconds(60));

/// A temporary folder for keys that only this user can read. The destructor removes it. It is in memory
/// (XDG_RUNTIME_DIR) if the system provides that, otherwise among the temporary files.
class PrivateFolder {
 public:
  /// Creates the folder. Fails with storage.
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
