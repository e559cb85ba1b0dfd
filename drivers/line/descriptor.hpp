/// Waiting for an open file of the operating system.
#pragma once

#include <poll.h>

#include <cerrno>
#include <ctime>

#include "core/file.hpp"
#include "drivers/line/deadline.hpp"

namespace gyrotherm {

/// True once `descriptor` is ready for `events` (or broken); false if the time is over. A signal does not end the wait.
[[nodiscard]] inline bool ready(int descriptor, short events, const Deadline& deadline) {
  pollfd line{descriptor, events, 0};
  while (true) {
    const auto left = deadline.left();
    const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
    const timespec limit{seconds.count(), (left - seconds).count()};
    const int found = ppoll(&line, 1, &limit, nullptr);
    if (found >= 0 || errno != EINTR) return found > 0;
  }
}

/// Whether errno says that the call is to be made again once the descriptor is ready.
[[nodiscard]] inline bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace gyrotherm
