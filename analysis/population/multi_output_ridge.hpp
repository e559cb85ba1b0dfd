// SPDX-License-Identifier: Apache-2.0
/// Ridge regression of several axes on the same thermometers, all at once.
#pragma once

#include <Eigen/Core>

#include "core/result.hpp"

namespace gyrotherm::population {

// Y = Z W + 1 bᵀ + E: a column of Y and of W per output (an axis), a row of Z and Y per cluster. The rows of E are
// N(0, Ω); the columns of W are of the same prior but for the factor that Γ says: vec W is N(0, Γ ⊗ (nC)⁻¹). What is
// most likely minimises tr(R Ω⁻¹ Rᵀ) + n tr(W Γ⁻¹ Wᵀ C), R = Y − Z W − 1 bᵀ (Brown and Zidek, Ann. Stat. 8 (1980) 64).
//
// Let Q diagonalise both, QᵀΩQ = D and QᵀΓQ = I: then each column of Y Q is a ridge regression of its own with the
// penalty d n C, and there is nothing to iterate.
//
// Honestly: where Ω is a multiple of Γ all penalties are the same and Q drops out; where both are diagonal, Q mixes
// nothing. In both cases this is the separate ridges, to the last digit, and so it is without a penalty, whatever Ω
// (Zellner, J. Am. Stat. Assoc. 57 (1962) 348: the same inputs in each equation). Something is gained only where the
// axes' noises correlate, their slopes do not in the same way, and the penalty still counts beside the data: few hours,
// or thermometers that see nearly the same. Ask residual_correlation.hpp first.

/// How the outputs belong together, outputs × outputs, symmetric and positive definite.
struct OutputCovariances {
  Eigen::MatrixXd noise;   ///< Ω, in squares of the outputs' unit
  Eigen::MatrixXd slopes;  ///< Γ, likewise
};

/// The planes of all outputs.
struct MultiOutputPlanes {
  Eigen::MatrixXd weights;               ///< W, inputs × outputs
  Eigen::RowVectorXd b;                  ///< one per output
  Eigen::VectorXd effective_parameters;  ///< of each of the combinations Y Q, the constant's 1 included
};

/// Minimises the sum above, in closed form. C is symmetric and not negative: the covariance of the inputs that the
/// thermometers' uncertainty makes, as in methods::penalised_plane, which solves each of the combinations, or λI for a
/// plain ridge. Fails with usage if shapes differ, there are fewer than two rows or a value is not finite, and with
/// numeric if Ω or Γ is not positive definite.
[[nodiscard]] Result<MultiOutputPlanes> multi_output_ridge(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y,
                                                           const Eigen::MatrixXd& penalty,
                                                           const OutputCovariances& between);

/// The same with Ω from the data: that of the residuals of separate ridges (each penalty n C times its own output's
/// residual variance, so that Γ is I in the unit of the outputs), over the rows less the mean effective parameters; two
/// steps, and no iteration, as in Zellner's estimator. Then `penalty` is (the prior variance of a slope)⁻¹/n, and not
/// in units of the noise. Fails as above, and with usage if the rows are not more than the effective parameters.
struct EstimatedPlanes {
  MultiOutputPlanes planes;
  Eigen::MatrixXd noise;  ///< Ω as estimated
};
[[nodiscard]] Result<EstimatedPlanes> multi_output_ridge(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y,
                                                         const Eigen::MatrixXd& penalty);

}  // namespace gyrotherm::population
