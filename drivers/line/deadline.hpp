// SPDX-License-Identifier: Apache-2.0
/// The end of a wait on a line, by default on the steady clock, on which the kernel's waits run; a line in memory has a
/// clock of its own, which it moves.
#pragma once

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <string>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::drivers {

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

// When a line that failed may be tried again: at once after the first failure, then after 0.5, 1, 2, 4, 8, 10, 10, …
// s.

class Backoff {
 public:
  /// `clock`, if given, must outlive this; without one the steady clock counts.
  explicit Backoff(const Clock* clock = nullptr) : clock_(clock), next_(Duration::zero(), clock) {}
  void succeeded() { rest_ = Duration::zero(), failures_ = 0; }
  void failed() {
    constexpr Duration kFirst = std::chrono::milliseconds(500), kLongest = std::chrono::seconds(10);
    if (++failures_ < 2) return;
    rest_ = std::clamp(2 * rest_, kFirst, kLongest);
    next_ = Deadline(rest_, clock_);
  }
  /// It may be tried at once; if that fails too, it rests as after a second failure.
  void insist() { rest_ = Duration::zero(); }
  /// How long the line must rest still; zero: it may be tried.
  [[nodiscard]] Duration left() const { return rest_ == Duration::zero() ? rest_ : next_.left(); }
  /// "failed before, next try in 0.5 s"
  [[nodiscard]] std::string words() const {
    return fmt::format("failed before, next try in {:.1f} s", to_seconds(left()));
  }

 private:
  const Clock* clock_;
  int failures_ = 0;
  Duration rest_{};
  Deadline next_;
};

}  // namespace gyrotherm::drivers
