// SPDX-License-Identifier: Apache-2.0
/// A polynomial in the temperature and its rate, by least squares: y = Σ_{k=0}^{m} a_k T^k (+ a_{m+1} Ṫ + a_{m+2} T Ṫ),
/// the oldest compensation of ring laser gyros (Guo et al., Chin. Opt. Lett. 4 (2006) 576; Hong et al., IEEE LEOS 2008;
/// refs. 3–5 of the paper).
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Chooses "order", m of 1 … 3, and "rate terms", 0 or 1, as far as the inputs offer them, by held-out error.
[[nodiscard]] Result<Choice> choose_polynomial(std::span<const Fold> folds, const MethodOptions& options,
                                               const ProgressSink& progress);

/// Takes the inputs whose number of temperatures and gradients multiplied is at most m, those with a rate only if asked
/// for; the others keep the weight 0. Fits like fit_linear: inputs are standardised powers, which is the same
/// polynomial as in T mapped to [−1, 1]. Fails with usage if no input remains.
[[nodiscard]] Result<Fit> fit_polynomial(const FitInput& set, const HyperParameters& parameters,
                                         const MethodOptions& options);

}  // namespace gyrotherm::methods
