/// Multiple linear regression by least squares.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm {

/// Nothing is to be chosen.
[[nodiscard]] Result<Choice> choose_nothing(std::span<const Fold> folds, const MethodOptions& options,
                                            const ProgressSink& progress);

/// Column-pivoted QR with a constant; the shortest weights where inputs are dependent. Inputs that depend on the others
/// to one part in 10⁹ count as dependent. Effective parameters: the rank. Fails with usage if there are not more
/// samples than coefficients.
[[nodiscard]] Result<Fit> fit_linear(const FitInput& set, const HyperParameters& parameters,
                                     const MethodOptions& options);

}  // namespace gyrotherm
