// SPDX-License-Identifier: Apache-2.0
/// Least squares with standard uncertainties that remain valid for correlated noise in short records.
#pragma once

#include <Eigen/Core>

namespace gyrotherm::data {

/// Least-squares coefficients, their standard uncertainties, and the residual.
struct CorrelatedFit {
  Eigen::VectorXd coefficients, u, residual;
};

/// Fits `y` to the columns of `x` by ordinary least squares. Row k has the integer position `positions`(k); positions
/// rise.
///
/// The noise is the sum of white noise and of a first-order Gauss-Markov process, whose correlation decreases by
/// exp(−1) within τ positions. The share of the process and τ are unknown. For each pair on a grid, the covariance of
/// the coefficients is (XᵀX)⁻¹XᵀΣX(XᵀX)⁻¹, with the scale of Σ estimated by restricted maximum likelihood (Patterson,
/// Thompson, Biometrika 58 (1971) 545), which accounts for the fitted coefficients, but at most twice the
/// scale that follows from the sum of squares of the residual. u² is the mean of this covariance, weighted by the
/// restricted likelihood. White noise alone has three times the prior weight of all other pairs together. τ doubles
/// from 1 and ends with `longest`; 0 stands for white noise only.
///
/// A sum of products of scores (Newey, West, Econometrica 55 (1987) 703) needs a record of many correlation times, and
/// its u is too small by a factor of 2 to 4 otherwise.
///
/// Asserts at least three more rows than columns, and columns that are linearly independent.
[[nodiscard]] CorrelatedFit fit_with_correlated_noise(const Eigen::MatrixXd& x, const Eigen::VectorXd& y,
                                                      const Eigen::VectorXi& positions, int longest);

}  // namespace gyrotherm::data
