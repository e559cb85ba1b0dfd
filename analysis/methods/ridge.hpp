/// Ridge regression on physics features: T, T², gradients, gradients times T, and the rate. One of the two modern
/// methods beside the paper's (Hoerl and Kennard, Technometrics 12 (1970) 55).
///
/// Why this one and not boosted trees: a bias that follows from heat flow is smooth in temperatures and gradients,
/// which these features say to second order, and a penalised plane through them goes on sensibly beyond the trained
/// range. A tree is constant between its cuts and beyond them: it would put steps into the compensated rate,
/// extrapolate by standing still, and need a thousand times the numbers in a navigation computer.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm {

/// "lambda": 10⁻⁸ … 10² in decades, by held-out error.
[[nodiscard]] Result<Choice> choose_ridge(std::span<const Fold> folds, const MethodOptions& options,
                                          const ProgressSink& progress);

/// Minimises ‖y − Zw − b‖² + λn‖w‖². Effective parameters: the trace.
[[nodiscard]] Result<Fit> fit_ridge(const FitInput& set, const HyperParameters& parameters,
                                    const MethodOptions& options);

}  // namespace gyrotherm
