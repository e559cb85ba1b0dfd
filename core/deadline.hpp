// SPDX-License-Identifier: Apache-2.0
/// Deadlines for waits. By default a deadline uses the steady clock, as the kernel's waits do. An in-memory connection
/// passes its own clock, which it advances itself.
#pragma once

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <ctime>

#include "core/clock.hpp"

namespace gyrotherm {

class Deadline {
 public:
  explicit Deadline(Duration within) : end_(now() + within) {}
  /// Uses `clock`, which must outlive this object.
  Deadline(Duration within, const Clock* clock) : clock_(clock), end_(now() + within) {}
  /// Returns the time until the deadline, or zero if it has passed.
  [[nodiscard]] Duration left() const { return std::max<Duration>(end_ - now(), Duration::zero()); }
  [[nodiscard]] bool has_passed() const { return left() == Duration::zero(); }

 private:
  [[nodiscard]] Duration now() const {
    return clock_ != nullptr ? clock_->now().since_start
                             : Duration(std::chrono::steady_clock::now().time_since_epoch());
  }

  /// The steady clock if null.
  const Clock* clock_ = nullptr;
  Duration end_;
};

/// Waits until `descriptor` is ready for `events` (poll(2)) or has an error, and returns true. Returns false at the
/// deadline. A signal does not end the wait.
[[nodiscard]] inline bool wait_until_ready(int descriptor, short events, const Deadline& deadline) {
  pollfd line{descriptor, events, 0};
  while (true) {
    const auto left = deadline.left();
    const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
    const timespec limit{seconds.count(), (left - seconds).count()};
    const int found = ppoll(&line, 1, &limit, nullptr);
    if (found >= 0 || errno != EINTR) return found > 0;
  }
}

/// Returns whether errno means that the call can be repeated once the descriptor is ready.
[[nodiscard]] inline bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace gyrotherm
