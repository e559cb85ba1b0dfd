// SPDX-License-Identifier: Apache-2.0
/// Runs third-party programs that create or verify the signatures of reports, as child processes.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::report {

struct ProgramRun {
  int exit_code{};
  std::string out{};  ///< stdout and stderr, in order
};

/// Runs a program of the PATH to its end, in English, in UTC and with an empty stdin. No shell interprets `arguments`.
/// Fails with bad_file and the name of the Debian package if the program is not installed, with timeout if it does not
/// end in time, with refused if a signal ended it, and with interrupted, after it has ended the program, if this
/// process received SIGINT, SIGTERM or SIGHUP while a PrivateFolder exists. The output does not contain the paths of
/// private folders and memory files.
[[nodiscard]] Result<ProgramRun> run_program(const std::string& program, const std::vector<std::string>& arguments,
                                             std::chrono::milliseconds longest = std::chrono::seconds(60));

/// Returns `text` without the paths of private folders, so that it contains only the names of their files, and with
/// "memory" for each MemoryFile of this process.
[[nodiscard]] std::string hide_private_paths(std::string text);

/// A temporary folder that only this user can read. The destructor removes it. It is in memory (XDG_RUNTIME_DIR) if the
/// system provides that, otherwise among the temporary files. SIGKILL and a power cut leave it, so it must not contain
/// a private key in clear; MemoryFile is for keys. While a folder exists, SIGINT, SIGTERM and SIGHUP are blocked in the
/// thread that made it. They take effect after the last folder of the thread is removed. Destroy it in this thread.
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

/// A file without a name, in memory, for a key or a password. It ends with this process, also after SIGKILL. Child
/// processes of this user open it by its path.
class MemoryFile {
 public:
  /// Creates the file with this content. Fails with storage.
  [[nodiscard]] static Result<MemoryFile> make(std::string_view content = "");
  ~MemoryFile();
  MemoryFile(MemoryFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(MemoryFile&&) = delete;

  [[nodiscard]] std::string path() const;

 private:
  explicit MemoryFile(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

/// Returns a random password of 256 bits in hexadecimal. Fails with storage if the system has no random numbers.
[[nodiscard]] Result<std::string> make_random_password();

}  // namespace gyrotherm::report
