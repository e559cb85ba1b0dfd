/// Back-propagation network of one hidden layer: ŷ = v_0 + Σ_{k=1}^{h} v_k tanh(w_k0 + w_kᵀz), trained by
/// Levenberg–Marquardt (Yang, Qin and You, Proc. SPIE 7544 (2010), ref. 7 of the paper).
///
/// A network depends on where its training starts, so ten seeded starts are tried. For each number of hidden units and
/// of steps their ten held-out errors are sorted; the median decides, not the luckiest. Stopping early is choosing the
/// number of steps with the least such median. The stored network is the start that is the (lower) median itself, so
/// that its held-out figures are those of a usual start. Quick: at most 10 hidden units and 40 steps.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm {

/// "hidden units": 5, 10 or 20; "steps": of Levenberg–Marquardt; "start": which of the ten, 0 … 9; by held-out error.
[[nodiscard]] Result<Choice> choose_network(std::span<const Fold> folds, const MethodOptions& options,
                                            const ProgressSink& progress);

/// Effective parameters: all weights, at most the samples; fewer steps make them less. Fails with usage if there is one
/// sample only.
[[nodiscard]] Result<Fit> fit_network(const FitInput& set, const HyperParameters& parameters,
                                      const MethodOptions& options);

}  // namespace gyrotherm
