// SPDX-License-Identifier: Apache-2.0
/// Support vectors and a plane in one kernel, whose plane costs what the thermometers' uncertainty makes of it.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

// A Gaussian kernel learns the path that its training walked: beyond it the function falls back to a constant, and the
// thermometers' errors are weighed by nothing. A plane goes on where the path ends, and what is left for the support
// vectors is the bend.
//
// Both are one kernel, k(z, z') = (z − m)ᵀ(cκP)⁻¹(z' − m) + a exp(−‖z − z'‖²/(2σ²)), and one solve with one certificate
// (svm/svr.hpp has the derivation). P = nU + I/kWidestSlope² is the penalty of ridge-u (ridge_u.hpp), U the covariance
// that the thermometers' errors make of the inputs, and c what an ε-insensitive loss counts where least squares counts
// 1: with κ = 1 the plane costs what it costs ridge-u, to first order. κ is the swarm's fourth coordinate and not below
// 1: held-out cycles share one state of the thermometers, and the search would pay the certificate away for them. a < 1
// is the same regularisation of the Gaussians, in closed form: their norm is weighed by a bound of what errors of the
// inputs add to the loss. To widen σ by the noise instead, as the expectation of the kernel over it does, would weigh
// what differs from sample to sample and not what is the same for all n of them: with σ² + 2u² for σ² it changes σ by
// less than 10⁻⁴ at 0.05 K.
//
// The target is in units of what the plane of ridge-u leaves of it, so that C, σ and ε are asked of the bend and not of
// the slope, and c is of a residual of STD 1.

/// Chooses C, sigma, epsilon and "plane penalty", κ, by tune_svr.
[[nodiscard]] ChooseFunction choose_svr_joint;

/// Fits both by solve_svr. The effective parameters are the support vectors that are not at their bound, as of fit_svr.
/// Fails like it.
[[nodiscard]] FitFunction fit_svr_joint;

}  // namespace gyrotherm::methods
