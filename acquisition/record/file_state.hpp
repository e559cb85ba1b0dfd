// SPDX-License-Identifier: Apache-2.0
/// What tells one state of a file from another.
#pragma once

#include <cstdint>
#include <string>

namespace gyrotherm::record {

/// File times are coarse, so that a file which replaced another at once may be as old; it has another number then.
struct FileState {
  std::uint64_t device{}, inode{};
  std::int64_t changed_ns{-1}, size{-1};
  bool operator==(const FileState&) const = default;
  [[nodiscard]] bool is_there() const { return size >= 0; }
};

/// Of what the path leads to; where nothing is there, the state of no file.
[[nodiscard]] FileState state_of(const std::string& path);
/// … of a file that grows: whether it is the same one.
[[nodiscard]] FileState identity_of(const std::string& path);

}  // namespace gyrotherm::record
