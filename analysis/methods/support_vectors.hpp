/// ε-SVR tuned by particle swarm: the paper's own method (eqs. 1–10).
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm {

/// C, sigma and epsilon by tune_svr.
[[nodiscard]] Result<Choice> choose_svr(std::span<const Fold> folds, const MethodOptions& options,
                                        const ProgressSink& progress);

/// Fails like solve_svr. Effective parameters: the support vectors that are not at their bound (Gunter, Zhu 2007).
[[nodiscard]] Result<Fit> fit_svr(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options);

}  // namespace gyrotherm
