// SPDX-License-Identifier: Apache-2.0
/// Ridge regression with a penalty given by the uncertainty of the thermometers, and the state-space model, which fits
/// the same kind of plane to temperatures and lags.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

// Errors in variables. A model must remain valid while its thermometers drift within their certificates. If the inputs
// of a cluster have an error e with the covariance C, a plane with slope w has the additional error e·w, with a mean
// square of wᵀCw. The plane with the lowest error on such readings minimises ‖y − Zw − b‖² + n wᵀCw (Fuller,
// Measurement Error Models (1987), §1.2; in Tikhonov's form: Golub, Hansen, O'Leary, SIAM J. Matrix Anal. 21 (1999)
// 185). On raw temperatures the penalty is n Σ u_i² w_i². Nothing is tuned: the certificate gives the penalty. C is
// FitInput.input_covariance, so products and lags are weighted by the propagated errors.

/// Plane fitted by penalised least squares.
struct PenalisedPlane {
  Eigen::VectorXd weights;
  double b{};
  /// Trace of the matrix from y to fitted values, including 1 for the constant.
  double effective_parameters{};
};

/// Minimises ‖y − Zw − b‖² + n wᵀCw without a penalty on b. Uses an orthogonal decomposition of the rows of Z stacked
/// on those of √(nC), which avoids squaring the condition number. C is symmetric and positive semidefinite. In
/// directions that neither C nor Z determines above its rounding errors, w has the least possible length. An input
/// clamped at the end of its range then has little effect.
[[nodiscard]] PenalisedPlane penalised_plane(const Eigen::Ref<const Eigen::MatrixXd>& z,
                                             const Eigen::Ref<const Eigen::VectorXd>& y,
                                             const Eigen::Ref<const Eigen::MatrixXd>& covariance);

/// Computes the penalised_plane of a set that passed check_set. Without a covariance its inputs are taken as exact.
[[nodiscard]] PenalisedPlane fit_plane(const FitInput& set);

/// Returns the residual of the plane of fit_plane().
[[nodiscard]] Eigen::VectorXd plane_residual(const FitInput& set);

/// Prior STD of the slope of a plane fitted together with Gaussians, in STDs of the target per STD of an input. Used if
/// the uncertainty of the thermometers is unknown.
inline constexpr double kWidestSlope = 100;

/// Returns the penalty on the slope of a plane fitted together with Gaussians, nC/variance + I/kWidestSlope². The first
/// term is the penalty of ridge-u in units of the residual variance; the second keeps the matrix positive definite.
/// Only the second is used if there is no covariance.
[[nodiscard]] Eigen::MatrixXd slope_penalty(const FitInput& set, double variance);

/// Fits the plane of fit_plane(). Fails with usage as check_set does.
[[nodiscard]] FitFunction fit_ridge_u;

// Linear state-space model with a few states, driven by the temperatures.
//
// A body of thermal conductances and capacities driven by temperatures has only real poles. In modal form each state
// follows its inputs with one time constant: dx_i/dt = (Σ_j b_ij T_j − x_i)/τ_i, bias = Σ_i c_i x_i + Σ_j d_j T_j + b.
// Only the products c_i b_ij are identifiable from one output. Their negatives are the weights of the
// lags T_j − F_ij of each thermometer with τ_i (data::FirstOrderLag). The model with n states is therefore the plane of
// fit_plane() on the temperatures and their lags with n time constants. Only the time constants are searched, by
// held-out error among all subsets of a bank (separable least squares; Golub, Pereyra, SIAM J. Numer. Anal. 10 (1973)
// 413).
//
// Subspace methods are not used. Eight temperatures of one block are nearly collinear (singular values of the
// standardised inputs from 2.7 to 0.0004), so the impulse responses that such methods require cannot be separated. The
// penalty used here sets weights to 0 where the thermometers cannot separate them. The poles of a subspace method may
// also be complex or unstable, which is impossible for a thermal body.

/// Largest number of states tried.
inline constexpr std::size_t kMostStates = 4;

/// Chooses 1 to kMostStates of the time constants of the lags in the terms. Compares all such sets. If no term has a
/// lag, the model has no state, and the choice contains a warning. Fails as choose_among does.
[[nodiscard]] ChooseFunction choose_state_space;

/// Fits a plane (see fit_plane()) whose inputs are the terms without a lag and the terms whose lag has a chosen time
/// constant ("tau_1_s", …). All other weights are 0. The number of effective parameters is that of the plane plus one
/// per state. Fails with usage as check_set does.
[[nodiscard]] FitFunction fit_state_space;

}  // namespace gyrotherm::methods
