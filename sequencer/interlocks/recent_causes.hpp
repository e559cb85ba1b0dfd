// SPDX-License-Identifier: Apache-2.0
/// Counts in how many of the last samples a cause was there, and for how long, so that a cause that comes and goes with
/// every second sample acts, too. Values; any thread.
#pragma once

#include <deque>

#include "core/quantity.hpp"

namespace gyrotherm::interlocks {

class RecentCauses {
 public:
  /// Adds a sample that was read and that covers `elapsed`. The window keeps at least the last `samples` samples and at
  /// least the last `time`.
  void add(bool found, Duration elapsed, int samples, Duration time) {
    window_.push_back({found, elapsed});
    count(window_.back(), 1);
    while (std::ssize(window_) > samples && whole_ - window_.front().elapsed >= time) {
      count(window_.front(), -1);
      window_.pop_front();
    }
  }
  void forget() { *this = {}; }

  [[nodiscard]] int samples() const { return samples_; }
  /// Returns the time covered by the samples in which the cause was there.
  [[nodiscard]] Duration time() const { return time_; }

 private:
  struct Entry {
    bool found{};
    Duration elapsed{};
  };
  void count(const Entry& entry, int sign) {
    whole_ += entry.elapsed * sign;
    if (!entry.found) return;
    time_ += entry.elapsed * sign;
    samples_ += sign;
  }

  std::deque<Entry> window_;
  int samples_{};
  Duration time_{}, whole_{};
};

}  // namespace gyrotherm::interlocks
