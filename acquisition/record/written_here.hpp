/// Which records this process writes. SQLite's locks belong to the process, and the close of any other descriptor of
/// the same file drops them all ("How To Corrupt", 2.2): so a record is never opened to be read where it is being
/// written.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>

namespace gyrotherm {

/// As long as it lives, the file that has this name now counts as written here. Any thread.
class WrittenHere {
 public:
  explicit WrittenHere(const std::string& path);
  ~WrittenHere();
  WrittenHere(const WrittenHere&) = delete;
  WrittenHere(WrittenHere&& other) noexcept : file_(std::exchange(other.file_, std::nullopt)) {}
  WrittenHere& operator=(WrittenHere&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }

 private:
  std::optional<std::pair<dev_t, ino_t>> file_;  ///< nothing: there was none
};

/// Nothing is opened to find that out. Any thread.
[[nodiscard]] bool is_written_here(const std::string& path);

}  // namespace gyrotherm
