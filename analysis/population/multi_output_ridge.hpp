// SPDX-License-Identifier: Apache-2.0
/// Joint ridge regression of several axes on the same thermometers.
#pragma once

#include <Eigen/Core>

#include "core/result.hpp"

namespace gyrotherm::population {

// Y = Z W + 1 bᵀ + E: one column of Y and W per output (axis), one row of Z and Y per cluster. The rows of E are N(0,
// Ω). The columns of W have the same prior up to the factor Γ: vec W is N(0, Γ ⊗ (nC)⁻¹). The maximum of the posterior
// minimises tr(R Ω⁻¹ Rᵀ) + n tr(W Γ⁻¹ Wᵀ C), R = Y − Z W − 1 bᵀ (Brown and Zidek, Ann. Stat. 8 (1980) 64).
//
// If Q diagonalises both, QᵀΩQ = D and QᵀΓQ = I, each column of Y Q is a separate ridge regression with the penalty d n
// C, and no iteration is needed.
//
// Limiting cases: if Ω is a multiple of Γ, all penalties are equal and Q cancels; if both are diagonal, Q does not mix
// outputs. In both cases the result equals that of separate ridges exactly. The same is true without a penalty, for any
// Ω (Zellner, J. Am. Stat. Assoc. 57 (1962) 348: the same inputs in each equation). Joint regression therefore helps
// only if the noises of the axes correlate, if their slopes do not correlate in the same way, and if the penalty is
// significant compared with the data, as with few hours of data or with thermometers that have nearly equal readings.
// residual_correlation.hpp tests for correlated noises.

/// Covariances between the outputs, outputs × outputs, symmetric and positive definite.
struct OutputCovariances {
  Eigen::MatrixXd noise;   ///< Ω, squares of the outputs' unit
  Eigen::MatrixXd slopes;  ///< Γ, squares of the outputs' unit
};

/// The planes of all outputs.
struct MultiOutputPlanes {
  Eigen::MatrixXd weights;  ///< W, inputs × outputs
  Eigen::RowVectorXd b;     ///< one per output
  /// One per column of Y Q, including 1 for the constant.
  Eigen::VectorXd effective_parameters;
};

/// Minimises the sum above in closed form; methods::penalised_plane() solves each column of Y Q. `penalty` is C,
/// symmetric and positive semidefinite: the covariance of the inputs due to the thermometers' uncertainty, or λI for an
/// ordinary ridge. Fails with usage if shapes differ, if there are fewer than two rows or if a value is not finite, and
/// with numeric if Ω or Γ is not positive definite.
[[nodiscard]] Result<MultiOutputPlanes> multi_output_ridge(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y,
                                                           const Eigen::MatrixXd& penalty,
                                                           const OutputCovariances& between);

/// Planes with Ω estimated from the data. Ω is the covariance of the residuals of separate ridges, divided by the
/// number of rows minus the mean number of effective parameters. The penalty of each ridge is n C times the residual
/// variance of its output, so Γ is I in the unit of the outputs. The estimate takes two steps without iteration, as in
/// Zellner's estimator.
struct EstimatedPlanes {
  MultiOutputPlanes planes;
  Eigen::MatrixXd noise;  ///< estimated Ω
};
/// Estimates Ω and the planes. `penalty` is the inverse of n times the prior variance of a slope; it is not in units of
/// the noise. Fails like the function above, and with usage if there are no more rows than effective parameters.
[[nodiscard]] Result<EstimatedPlanes> multi_output_ridge(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y,
                                                         const Eigen::MatrixXd& penalty);

}  // namespace gyrotherm::population
