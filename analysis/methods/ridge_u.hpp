// SPDX-License-Identifier: Apache-2.0
/// Ridge regression with the thermometers' uncertainty as its penalty, and the state-space model that is its plane on
/// lags.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

// Errors in variables: what a model learns from its thermometers has to last while they drift within their certificate.
// If the inputs of a cluster are in error by e, of covariance C, a plane of slope w is in error by e·w more, whose
// square is wᵀCw on average: the plane that errs least on readings that are in error minimises
// ‖y − Zw − b‖² + n wᵀCw (Fuller, Measurement Error Models (1987), §1.2; Tikhonov's form of it: Golub, Hansen, O'Leary,
// SIAM J. Matrix Anal. 21 (1999) 185). On raw temperatures that is n Σ u_i² w_i². Nothing is tuned: the certificate
// gives the penalty. C is FitInput.input_covariance, so products and lags are weighed by what the errors make of them.

/// The plane of penalised least squares.
struct PenalisedPlane {
  Eigen::VectorXd weights;
  double b{};
  double effective_parameters{};  ///< the trace of the matrix from y to fitted values, the constant's 1 included
};

/// Minimises ‖y − Zw − b‖² + n wᵀCw, b free, by an orthogonal decomposition of the rows of Z above those of √(nC): no
/// square of a condition number. C is symmetric and not negative; where neither it nor Z tells directions apart but by
/// rounding, the shortest w is taken: an input that is clamped at the end of its range then moves little.
[[nodiscard]] PenalisedPlane penalised_plane(const Eigen::Ref<const Eigen::MatrixXd>& z,
                                             const Eigen::Ref<const Eigen::VectorXd>& y,
                                             const Eigen::Ref<const Eigen::MatrixXd>& covariance);

/// The penalised_plane of a sound set (check_set); without a covariance its inputs are taken as exact.
[[nodiscard]] PenalisedPlane plane_of(const FitInput& set);

/// What plane_of leaves of the target.
[[nodiscard]] Eigen::VectorXd beside_the_plane(const FitInput& set);

/// How steep a plane beside Gaussians may be, in STDs of the target per STD of an input, where the thermometers'
/// uncertainty does not say.
inline constexpr double kWidestSlope = 100;

/// What the slope of a plane beside Gaussians costs, nC/variance + I/kWidestSlope²: the penalty of ridge-u in units of
/// the variance of what the plane leaves, and what keeps it positive definite. Without a covariance the second alone.
[[nodiscard]] Eigen::MatrixXd slope_penalty(const FitInput& set, double variance);

/// Fits plane_of. Fails with usage as check_set does.
[[nodiscard]] FitFunction fit_ridge_u;

// The linear state-space model of a few states, driven by the temperatures.
//
// A body of thermal conductances and capacities, driven by its temperatures, has real poles alone. In the modal form of
// such a model each state follows what drives it with one time constant: dx_i/dt = (Σ_j b_ij T_j − x_i)/τ_i,
// bias = Σ_i c_i x_i + Σ_j d_j T_j + b. Of one output the products c_i b_ij are all that can be told, and they are,
// with the other sign, the weights of the lags T_j − F_ij of each thermometer with τ_i (data::FirstOrderLag). So the
// model of n states is plane_of on the temperatures and their lags with n time constants, and only those are left to
// search: by held-out error, among all sets of a bank of time constants (separable least squares; Golub, Pereyra, SIAM
// J. Numer. Anal. 10 (1973) 413).
//
// Why not a subspace method: eight temperatures of one block are nearly one (singular values of the standardised inputs
// from 2.7 to 0.0004), so that the impulse responses on which it rests cannot be told apart, while the penalty here
// takes what the thermometers cannot tell as 0; and its poles may be complex or unstable, which no block is.

/// As many states as are tried.
inline constexpr std::size_t kMostStates = 4;

/// Chooses the set of 1 to kMostStates of the time constants among the terms' lags, whole sets against each other.
/// Terms without a lag make a model without a state, and a warning. Fails as choose_among does.
[[nodiscard]] ChooseFunction choose_state_space;

/// Fits plane_of on the terms whose lags, if any, have a chosen time constant, "tau_1_s" …; the others weigh nothing.
/// The effective parameters are the plane's and one per state. Fails with usage as check_set does.
[[nodiscard]] FitFunction fit_state_space;

}  // namespace gyrotherm::methods
