// SPDX-License-Identifier: Apache-2.0
/// Noise model of the residual of a plane: white noise, wander and a constant per run. Clusters within an hour are
/// correlated; treating them as independent would make the uncertainty too small.
#pragma once

#include <Eigen/Core>

namespace gyrotherm::population {

/// Noise of cluster means: white noise, a first-order Gauss–Markov process with the covariance s² exp(−|Δt|/τ) (the
/// wander: effects that a plane in the inputs does not describe, such as hysteresis, curvature and bias instability),
/// and a constant per run, the turn-on. The values are standard deviations, °/h, and not negative.
struct UnexplainedNoise {
  /// Noise of one mean; above 0.
  double white_deg_per_h{};
  double wander_deg_per_h{};
  double wander_time_s = 1;  ///< τ, above 0
  double turn_on_deg_per_h{};
};

/// Returns the noise covariance of means at the times `time_s` of one run.
[[nodiscard]] Eigen::MatrixXd noise_covariance(const UnexplainedNoise& noise, const Eigen::VectorXd& time_s);

/// Columns whose noise is white with variance 1.
struct WhitenedColumns {
  Eigen::MatrixXd columns;
  /// Log determinant of the noise's covariance.
  double log_determinant{};
};

/// Whitens columns with one row per mean of one run at `time_s`, in ascending order: the innovations of a Kalman
/// filter, divided by their standard deviations. This equals the product with the inverse of the covariance's Cholesky
/// factor, in a time proportional to the number of rows (Anderson and Moore, Optimal Filtering (1979), §5.3 and §9.4).
[[nodiscard]] WhitenedColumns whiten(const UnexplainedNoise& noise, const Eigen::VectorXd& time_s,
                                     const Eigen::MatrixXd& columns);

}  // namespace gyrotherm::population
