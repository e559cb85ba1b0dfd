// SPDX-License-Identifier: Apache-2.0
/// A file that cannot be replaced, as on a full disk.
#pragma once

#include <filesystem>
#include <string>

namespace gyrotherm::monitor {

/// Moves a file away and puts a folder in its place, so writing the file fails. The destructor restores the file.
class BlockedFile {
 public:
  explicit BlockedFile(std::string path) : path_(std::move(path)) {
    std::filesystem::rename(path_, path_ + ".kept");
    std::filesystem::create_directories(path_ + "/full");
  }
  ~BlockedFile() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
    std::filesystem::rename(path_ + ".kept", path_, error);
  }
  BlockedFile(const BlockedFile&) = delete;
  BlockedFile& operator=(const BlockedFile&) = delete;

 private:
  std::string path_;
};

}  // namespace gyrotherm::monitor
