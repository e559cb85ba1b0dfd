// SPDX-License-Identifier: Apache-2.0
/// Smoothing of the bias from earlier and later rates, for plots and as an off-line reference. It is not used for any
/// result, because a smoother uses the very values that a tracker must predict.
#pragma once

#include <Eigen/Core>

#include "analysis/tracking/state_space.hpp"

namespace gyrotherm::tracking {

/// Bias in each interval, °/h, with the standard deviation of its error.
struct SmoothedBias {
  Eigen::VectorXd deg_per_h, std_deg_per_h;
};

/// Smooths with a fixed interval (Rauch, Tung and Striebel, AIAA J. 3 (1965) 1445): returns the mean of the bias in
/// each interval, given all rates. Missing rates are NaN. Uses the backward recursion of de Jong (Biometrika 75 (1988)
/// 594), which gives the same result without inverting a covariance. A state with zero variance is therefore permitted.
[[nodiscard]] SmoothedBias smooth(const StateSpace& space, const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h);

/// Smooths with a fixed lag: index k holds the bias of interval k − lag given the rates up to k. NaN for the first
/// `lag` indices. A lag of 0 gives the estimates of BiasTracker.
[[nodiscard]] Eigen::VectorXd smooth_with_lag(const StateSpace& space,
                                              const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h,
                                              Eigen::Index lag);

}  // namespace gyrotherm::tracking
