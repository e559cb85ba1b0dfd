// SPDX-License-Identifier: Apache-2.0
/// A linear state-space model of a few states, driven by the temperatures.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

// A body of thermal conductances and capacities, driven by its temperatures, has real poles alone. In the modal form of
// such a model each state follows what drives it with one time constant: dx_i/dt = (Σ_j b_ij T_j − x_i)/τ_i,
// bias = Σ_i c_i x_i + Σ_j d_j T_j + b. Of one output the products c_i b_ij are all that can be told, and they are,
// with the other sign, the weights of the lags T_j − F_ij of each thermometer with τ_i (data::FirstOrderLag). So the
// model of n states is ridge-u's plane (ridge_u.hpp) on the temperatures and their lags with n time constants, and only
// those are left to search: by held-out error, among all sets of a bank of time constants (separable least squares;
// Golub, Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).
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
