// SPDX-License-Identifier: Apache-2.0
/// Bias tracking of a stream: a compensated rate a second in, the bias that is left in it out.
#pragma once

#include <cstdint>

#include "analysis/tracking/bias_tracker.hpp"

namespace gyrotherm::tracking {

/// Averages the rates of an interval and pushes the mean if the gyro was at rest all the while. What it says of a row
/// is from the intervals before it: it takes nothing of a row's own noise or rotation away.
class RestTracker {
 public:
  /// `rows` of the stream make an interval of the space.
  RestTracker(const StateSpace& space, int rows);

  /// The next row: what the thermal model left, NaN where that is not known. Returns the bias to take from it.
  Estimate push(double rate_deg_per_h, bool at_rest);
  /// Rows that are missing: the bias wanders on, and nothing is seen of it.
  void pass(std::int64_t rows);

  [[nodiscard]] const BiasTracker& tracker() const { return tracker_; }

 private:
  BiasTracker tracker_;
  int rows_;
  int pushed_{};   ///< of this interval
  double sum_{};   ///< of its rates; NaN if one counts for nothing
  Estimate bias_;  ///< in this interval, foretold
};

}  // namespace gyrotherm::tracking
