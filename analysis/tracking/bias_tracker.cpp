// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/bias_tracker.hpp"

#include <cassert>
#include <cmath>
#include <limits>

namespace gyrotherm::tracking {

BiasTracker::BiasTracker(const StateSpace& space) : space_(space), covariance_(space.start.asDiagonal()) {}

TrackedInterval BiasTracker::push(double rate_deg_per_h) {
  if (started_) {
    state_ = state_.cwiseProduct(space_.memory);
    covariance_ = covariance_.cwiseProduct(space_.memory * space_.memory.transpose());
    covariance_.diagonal() += space_.fresh;
  }
  started_ = true;
  TrackedInterval interval{.predicted = state_,
                           .predicted_covariance = covariance_,
                           .innovation = rate_deg_per_h - state_.sum(),
                           .innovation_variance = covariance_.sum() + space_.white};
  if (!std::isfinite(rate_deg_per_h)) {
    interval.innovation = std::numeric_limits<double>::quiet_NaN();
    return interval;
  }
  const State gain = covariance_.rowwise().sum() / interval.innovation_variance;
  const Covariance kept = Covariance::Identity() - gain * State::Ones().transpose();
  state_ += gain * interval.innovation;
  covariance_ = (kept * covariance_ * kept.transpose() + space_.white * gain * gain.transpose()).eval();
  return interval;
}

Estimate BiasTracker::estimate() const { return {state_.sum(), std::sqrt(covariance_.sum())}; }

Estimate BiasTracker::forecast(int intervals) const {
  assert(intervals >= 1);
  // Weight of a state that applies n intervals before the end, in the sum of the bias over these n intervals.
  State weight = State::Zero();
  double fresh = 0;
  for (int n = 1; n <= intervals; ++n) {
    weight = (State::Ones() + weight.cwiseProduct(space_.memory)).eval();
    fresh += weight.cwiseAbs2().dot(space_.fresh);
  }
  weight = weight.cwiseProduct(space_.memory) / intervals;
  const double variance = weight.dot(covariance_ * weight) + fresh / (static_cast<double>(intervals) * intervals);
  return {weight.dot(state_), std::sqrt(variance)};
}

std::vector<TrackedInterval> track(const StateSpace& space, const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h) {
  BiasTracker tracker(space);
  std::vector<TrackedInterval> intervals;
  intervals.reserve(static_cast<std::size_t>(rates_deg_per_h.size()));
  for (const double rate : rates_deg_per_h) intervals.push_back(tracker.push(rate));
  return intervals;
}

RestTracker::RestTracker(const StateSpace& space, int rows) : tracker_(space), rows_(rows), bias_(tracker_.estimate()) {
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

void RestTracker::skip_rows(std::int64_t rows) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  for (; rows > 0 && pushed_ > 0; --rows) push(kMissing, false);
  for (; rows >= rows_; rows -= rows_) {
    tracker_.push(kMissing);
    bias_ = tracker_.forecast(1);
  }
  for (; rows > 0; --rows) push(kMissing, false);
}

}  // namespace gyrotherm::tracking
