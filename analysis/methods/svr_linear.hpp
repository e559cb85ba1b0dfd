// SPDX-License-Identifier: Apache-2.0
/// Support vectors beside a plane: ε-SVR whose kernel is a linear one and a Gaussian one.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

// A Gaussian kernel learns the path that its training walked: beyond it the function falls back to a constant, and the
// thermometers' errors are weighed by nothing. With z·z′ beside it the plane is carried by the linear part, which goes
// on where the path ends, and what is left for the support vectors is the bend.
//
// The linear part is ridge-u's plane (ridge_u.hpp), so that its input noise is that of the certificate in closed form:
// to add u² Σ(∂f/∂T_i)² to the loss, or to train on jittered copies of the inputs, is the same to first order (Bishop,
// Neural Comput. 7 (1995) 108), and only the closed form is exact, has nothing to draw and no copy to solve for. It is
// fitted first and the support vectors to what it leaves, which is the solution with both kernels in the limit of a
// plane that costs nothing beside its penalty: their weight against each other is not searched.

/// Chooses C, sigma and epsilon by tune_svr on what the plane of each fold's training rows leaves of the fold, in units
/// of what it leaves of them.
[[nodiscard]] ChooseFunction choose_svr_linear;

/// Fits the plane, then support vectors by fit_svr. The effective parameters are the sum of both. Fails like them.
[[nodiscard]] FitFunction fit_svr_linear;

}  // namespace gyrotherm::methods
