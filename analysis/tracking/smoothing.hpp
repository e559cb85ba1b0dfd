// SPDX-License-Identifier: Apache-2.0
/// The bias as it is known afterwards, from what came before and after: for drawings and as an off-line reference. It
/// scores nothing: a smoother has seen what a tracker must foretell.
#pragma once

#include <Eigen/Core>

#include "analysis/tracking/state_space.hpp"

namespace gyrotherm::tracking {

/// The bias in each interval, °/h, and the standard deviation of its error.
struct SmoothedBias {
  Eigen::VectorXd deg_per_h, std_deg_per_h;
};

/// The fixed-interval smoother of Rauch, Tung and Striebel (AIAA J. 3 (1965) 1445): the mean of each bias, given all
/// rates (NaN where one is missing). It is computed by the backward recursion of de Jong (Biometrika 75 (1988) 594),
/// which gives the same and inverts no covariance, so that a state of no variance does no harm.
[[nodiscard]] SmoothedBias smooth(const StateSpace& space, const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h);

/// The fixed-lag smoother: at place k the bias of interval k − lag, given the rates up to k; NaN for the first `lag`
/// places. A lag of 0 is the tracker.
[[nodiscard]] Eigen::VectorXd smooth_with_lag(const StateSpace& space,
                                              const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h,
                                              Eigen::Index lag);

}  // namespace gyrotherm::tracking
