// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/rest_tracker.hpp"

#include <cassert>
#include <limits>

namespace gyrotherm::tracking {

RestTracker::RestTracker(const StateSpace& space, int rows) : tracker_(space), rows_(rows), bias_(tracker_.now()) {
  assert(rows >= 1);
}

Estimate RestTracker::push(double rate_deg_per_h, bool at_rest) {
  const Estimate bias = bias_;
  sum_ += at_rest ? rate_deg_per_h : std::numeric_limits<double>::quiet_NaN();
  if (++pushed_ < rows_) return bias;
  tracker_.push(sum_ / rows_);
  bias_ = tracker_.forecast(1);
  pushed_ = 0;
  sum_ = 0;
  return bias;
}

void RestTracker::pass(std::int64_t rows) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  for (; rows > 0 && pushed_ > 0; --rows) push(kMissing, false);
  for (; rows >= rows_; rows -= rows_) {
    tracker_.push(kMissing);
    bias_ = tracker_.forecast(1);
  }
  for (; rows > 0; --rows) push(kMissing, false);
}

}  // namespace gyrotherm::tracking
