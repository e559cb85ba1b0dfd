// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/file_state.hpp"

#include <sys/stat.h>

namespace gyrotherm::record {

FileState state_of(const std::string& path) {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return {};
  return {.device = facts.st_dev,
          .inode = facts.st_ino,
          .changed_ns = std::int64_t{facts.st_mtim.tv_sec} * kNanoseconds + facts.st_mtim.tv_nsec,
          .size = facts.st_size};
}

FileState identity_of(const std::string& path) {
  auto state = state_of(path);
  if (state.is_there()) state.changed_ns = state.size = 0;
  return state;
}

}  // namespace gyrotherm::record
