// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/state_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "core/file.hpp"

namespace gyrotherm::monitor {

std::string resolve_state_folder(const std::string& given) {
  if (!given.empty()) return given;
  if (const char* systemd = std::getenv("STATE_DIRECTORY")) return systemd;
  if (const char* state = std::getenv("XDG_STATE_HOME")) return std::string(state) + "/gyrotherm-monitor";
  const char* home = std::getenv("HOME");
  return std::string(home != nullptr ? home : ".") + "/.local/state/gyrotherm-monitor";
}

Result<void> make_state_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(folder).parent_path(), error);
  if (::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST) return {};
  return failure(FaultKind::storage, folder, std::strerror(errno));
}

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
    return failure(FaultKind::bad_file, path, "is accessible to other users, expected mode 0600");
  return read_whole(*opened, path).map([](std::string text) { return std::optional(std::move(text)); });
}

Result<void> write_private_file(const std::string& path, std::string_view text) {
  return replace_own_file(path, text, Syncing::awaited, Readers::owner);
}

}  // namespace gyrotherm::monitor
