// SPDX-License-Identifier: Apache-2.0
/// Estimates the time to the end of a stage from its progress.
#pragma once

#include <optional>

#include "core/quantity.hpp"

namespace gyrotherm::app {

/// Assumes that the fraction continues to grow as it has grown on average. While the fraction does not change, the time
/// left decreases like a clock, and is unknown when the clock reaches zero. Not thread-safe.
class TimeLeft {
 public:
  /// Takes the fraction after `spent`, the time since the stage began. Returns the time left, or nothing until 1 % and
  /// two seconds have passed, at the end, or if it is unknown.
  [[nodiscard]] std::optional<Duration> after(double fraction, Duration spent);

 private:
  double fraction_ = 0;
  /// Time of the last change of the fraction.
  Duration changed_{};
};

}  // namespace gyrotherm::app
