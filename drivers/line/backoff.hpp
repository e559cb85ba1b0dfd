// SPDX-License-Identifier: Apache-2.0
/// When a line that failed may be tried again: at once after the first failure, then after 0.5, 1, 2, 4, 8, 10, 10, …
/// s.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::drivers {

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
  void end_rest() { rest_ = Duration::zero(); }
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
