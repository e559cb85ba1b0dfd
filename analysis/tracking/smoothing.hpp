// SPDX-License-Identifier: Apache-2.0
/// Smoothing of the bias from earlier and later rates, for plots and as an off-line reference. It is not used in any
/// result, because a smoother uses the values that a tracker must predict.
#pragma once

#include <Eigen/Core>

#include "analysis/tracking/state_space.hpp"

namespace gyrotherm::tracking {

/// Bias in each interval, °/h, with the standard deviation of its error.
struct SmoothedBias {
  Eigen::VectorXd deg_per_h, std_deg_per_h;
};

/// Smooths with a fixed interval (Rauch, Tung and Striebel, AIAA J. 3 (1965) 1445): returns the mean of each bias given
/// all rates (NaN where one is missing). Uses the backward recursion of de Jong (Biometrika 75 (1988) 594). It gives
/// the same result without inverting a covariance, so a state with zero variance is permitted.
[[nodiscard]] SmoothedBias smooth(const StateSpace& space, const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h);

/// Smooths with a fixed lag: index k holds the bias of interval k − lag given the rates up to k. NaN for the first
/// `lag` indices. A lag of 0 gives the tracker.
[[nodiscard]] Eigen::VectorXd smooth_with_lag(const StateSpace& space,
                                              const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h,
                                              Eigen::Index lag);

}  // namespace gyrotherm::tracking
