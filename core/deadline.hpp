// SPDX-License-Identifier: Apache-2.0
/// The end of a wait, by default on the steady clock, on which the kernel's waits run; a line in memory has a clock of
/// its own, which it moves.
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
  /// `clock` must outlive this.
  Deadline(Duration within, const Clock* clock) : clock_(clock), end_(now() + within) {}
  /// What is left; zero once it is over.
  [[nodiscard]] Duration left() const { return std::max<Duration>(end_ - now(), Duration::zero()); }
  [[nodiscard]] bool over() const { return left() == Duration::zero(); }

 private:
  [[nodiscard]] Duration now() const {
    return clock_ != nullptr ? clock_->now().since_start
                             : Duration(std::chrono::steady_clock::now().time_since_epoch());
  }

  const Clock* clock_ = nullptr;  ///< none: the steady clock
  Duration end_;
};

// Waiting for an open file of the operating system.

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
