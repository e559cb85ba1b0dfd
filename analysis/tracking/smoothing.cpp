// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/smoothing.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "analysis/tracking/bias_tracker.hpp"

namespace gyrotherm::tracking {
namespace {

/// Information from later intervals about the preceding state. With r and N of de Jong, the smoothed state is x + P r
/// and its covariance P − P N P, where x and P are the predicted state and covariance.
struct Hindsight {
  State r = State::Zero();
  Covariance n = Covariance::Zero();
};

/// Moves the recursion back over one interval.
Hindsight step_back(const Hindsight& after, const StateSpace& space, const TrackedInterval& interval) {
  Hindsight hindsight{after.r.cwiseProduct(space.memory),
                      after.n.cwiseProduct(space.memory * space.memory.transpose())};
  if (std::isnan(interval.innovation)) return hindsight;
  const State observation = State::Ones();
  const State gain = interval.predicted_covariance.rowwise().sum() / interval.innovation_variance;
  const Covariance kept = Covariance::Identity() - gain * observation.transpose();
  hindsight.r = kept.transpose() * hindsight.r + observation * (interval.innovation / interval.innovation_variance);
  hindsight.n =
      kept.transpose() * hindsight.n * kept + observation * observation.transpose() / interval.innovation_variance;
  return hindsight;
}

Estimate smoothed(const TrackedInterval& interval, const Hindsight& hindsight) {
  const State reach = interval.predicted_covariance.rowwise().sum();
  const double variance = reach.sum() - reach.dot(hindsight.n * reach);
  return {interval.predicted.sum() + reach.dot(hindsight.r), std::sqrt(std::max(0.0, variance))};
}

}  // namespace

SmoothedBias smooth(const StateSpace& space, const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h) {
  const std::vector<TrackedInterval> intervals = track(space, rates_deg_per_h);
  SmoothedBias bias{Eigen::VectorXd(rates_deg_per_h.size()), Eigen::VectorXd(rates_deg_per_h.size())};
  Hindsight hindsight;
  for (Eigen::Index k = rates_deg_per_h.size() - 1; k >= 0; --k) {
    const TrackedInterval& interval = intervals[static_cast<std::size_t>(k)];
    hindsight = step_back(hindsight, space, interval);
    const Estimate estimate = smoothed(interval, hindsight);
    bias.deg_per_h(k) = estimate.deg_per_h;
    bias.std_deg_per_h(k) = estimate.std_deg_per_h;
  }
  return bias;
}

Eigen::VectorXd smooth_with_lag(const StateSpace& space, const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h,
                                Eigen::Index lag) {
  assert(lag >= 0);
  const std::vector<TrackedInterval> intervals = track(space, rates_deg_per_h);
  const Eigen::Index count = rates_deg_per_h.size();
  Eigen::VectorXd bias = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = lag; k < count; ++k) {
    Hindsight hindsight;
    for (Eigen::Index j = k; j >= k - lag; --j) {
      hindsight = step_back(hindsight, space, intervals[static_cast<std::size_t>(j)]);
    }
    bias(k) = smoothed(intervals[static_cast<std::size_t>(k - lag)], hindsight).deg_per_h;
  }
  return bias;
}

}  // namespace gyrotherm::tracking
