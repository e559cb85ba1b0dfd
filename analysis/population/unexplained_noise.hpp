// SPDX-License-Identifier: Apache-2.0
/// What a plane leaves of a unit's bias, as noise: white, wandering, and constant over a run. Means of one hour are not
/// as many independent values as there are clusters in it; who takes them to be promises an uncertainty that is too
/// small.
#pragma once

#include <Eigen/Core>

namespace gyrotherm::population {

/// The noise of cluster means: white noise, a first-order Gauss–Markov process of the covariance s² exp(−|Δt|/τ) (what
/// the inputs do not tell: hysteresis, bends, bias instability), and a constant of each run, the turn-on. Standard
/// deviations, °/h; none is negative.
struct UnexplainedNoise {
  double white_deg_per_h{};  ///< of one mean; above 0
  double wander_deg_per_h{};
  double wander_time_s = 1;  ///< τ, above 0
  double turn_on_deg_per_h{};
};

/// The covariance of the noise of means at these times, s, of one run.
[[nodiscard]] Eigen::MatrixXd covariance_of(const UnexplainedNoise& noise, const Eigen::VectorXd& time_s);

/// Columns whose noise has become white and of variance 1.
struct Whitened {
  Eigen::MatrixXd columns;
  double log_determinant{};  ///< of the noise's covariance
};

/// Whitens columns, a row per mean of one run at `time_s`, which rises: the innovations of a Kalman filter over the
/// standard deviation of each, which is the columns multiplied by the inverse of the covariance's Cholesky factor, in a
/// time that goes with the rows (Anderson and Moore, Optimal Filtering (1979), §5.3 and §9.4).
[[nodiscard]] Whitened whiten(const UnexplainedNoise& noise, const Eigen::VectorXd& time_s,
                              const Eigen::MatrixXd& columns);

}  // namespace gyrotherm::population
