// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/standard/history_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "core/clock.hpp"
#include "core/deadline.hpp"

namespace gyrotherm::app {
namespace {

constexpr int kLockPollMs = 20;

std::string lock_path(const std::string& history) {
  std::error_code error;
  const auto resolved = std::filesystem::weakly_canonical(history, error);
  return (error ? history : resolved.string()) + ".lock";
}

}  // namespace

Result<Descriptor> lock_history(const std::string& history, Duration within) {
  constexpr mode_t kMode = 0664;
  const auto path = lock_path(history);
  Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, kMode));
  if (!file.is_open())
    return failure(FaultKind::storage, path, fmt::format("cannot be locked: {}", std::strerror(errno)));
  const Deadline deadline(within);
  for (;;) {
    struct flock whole {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    if (::fcntl(file.number(), F_OFD_SETLK, &whole) == 0) return file;
    if (errno != EAGAIN && errno != EACCES && errno != EINTR)
      return failure(FaultKind::storage, path, fmt::format("cannot be locked: {}", std::strerror(errno)));
    if (deadline.has_passed())
      return failure(FaultKind::timeout, history,
                     fmt::format("another program has been adding to it for {}", format_duration(within)));
    ::poll(nullptr, 0, kLockPollMs);
  }
}

}  // namespace gyrotherm::app
