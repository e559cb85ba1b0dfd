// SPDX-License-Identifier: Apache-2.0
#include "monitor/private_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
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
  const auto fresh = path + ".new";
  const auto refuse = [&] { return failure(FaultKind::storage, path, std::strerror(errno)); };
  ::unlink(fresh.c_str());
  Descriptor file(::open(fresh.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_WRONLY | O_CLOEXEC, 0600));
  if (!file.is_open()) return refuse();
  while (!text.empty()) {
    const auto written = ::write(file.number(), text.data(), text.size());
    if (written <= 0) return refuse();
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fsync(file.number()) != 0 || ::rename(fresh.c_str(), path.c_str()) != 0) return refuse();
  return {};
}

}  // namespace gyrotherm::monitor
