// SPDX-License-Identifier: Apache-2.0
/// Support vectors beside a plane: ridge-u's plane, then Gaussian ε-SVR on what it leaves.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

// A Gaussian kernel learns the path that its training walked: beyond it the function falls back to a constant, and the
// thermometers' errors are weighed by nothing. A plane goes on where the path ends, and what is left for the support
// vectors is the bend.
//
// The plane is ridge-u's (ridge_u.hpp), so that its input noise is that of the certificate in closed form: to add
// u² Σ(∂f/∂T_i)² to the loss, or to train on jittered copies of the inputs, is the same to first order (Bishop, Neural
// Comput. 7 (1995) 108), and only the closed form is exact, has nothing to draw and no copy to solve for. Plane and
// support vectors are fitted one after the other (docs/decisions/0019-the-plane-carries-the-certificate.md).

/// Chooses C, sigma and epsilon by tune_svr on what the plane of each fold's training rows leaves of the fold, in units
/// of what it leaves of them.
[[nodiscard]] ChooseFunction choose_svr_linear;

/// Fits the plane, then support vectors by fit_svr. The effective parameters are the sum of both. Fails like them.
[[nodiscard]] FitFunction fit_svr_linear;

}  // namespace gyrotherm::methods
