// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/private_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/file.hpp"

namespace gyrotherm::monitor {

Result<std::optional<std::string>> read_private_file(const std::string& path) {
  struct stat facts {};
  if (::lstat(path.c_str(), &facts) != 0 && errno == ENOENT) return std::optional<std::string>();
  const auto opened = open_regular_file(path, Links::refused);
  if (!opened) return failure(opened.error());
  if (::fstat(opened->descriptor.number(), &facts) != 0)
    return failure(FaultKind::bad_file, path, std::strerror(errno));
  if (facts.st_uid != ::geteuid() && facts.st_uid != 0)
    return failure(FaultKind::bad_file, path, "belongs to another user");
  if ((facts.st_mode & 077) != 0)
    return failure(FaultKind::bad_file, path, "others than its owner may read or write it, expected mode 0600");
  return read_whole(*opened, path).map([](std::string text) { return std::optional(std::move(text)); });
}

Result<void> write_private_file(const std::string& path, std::string_view text) {
  return replace_own_file(path, text, Syncing::awaited, Readers::owner);
}

}  // namespace gyrotherm::monitor
