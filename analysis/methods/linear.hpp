// SPDX-License-Identifier: Apache-2.0
/// Multiple linear regression by least squares.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Fits by a column-pivoted QR with a constant, which gives the shortest weights where inputs are dependent. Inputs
/// that depend on the others to one part in 10⁹ count as dependent. The effective parameters are the rank. Fails with
/// usage if there are not more samples than coefficients.
[[nodiscard]] Result<Fit> fit_linear(const FitInput& set, const HyperParameters& parameters,
                                     const MethodOptions& options);

}  // namespace gyrotherm::methods
