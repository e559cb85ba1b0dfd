/// The modified radial basis network of Ding et al., Sensors 14 (2014) 18711, ref. 12 of the paper: a self-organising
/// map offers its nodes as centres, orthogonal least squares takes the few that explain the bias.
///
/// All units share one width, a multiple of the mean distance between a node and its two nearest.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm {

/// "width factor": of 1, 2, 4, 8, 16, and "tolerance": the part of the spread that may stay unexplained, 10⁻¹ … 10⁻⁴ in
/// quarter decades; by held-out error.
[[nodiscard]] Result<Choice> choose_kohonen(std::span<const Fold> folds, const MethodOptions& options,
                                            const ProgressSink& progress);

/// A map of 10 × 10 nodes. Effective parameters: the units taken and the constant; that they were picked is not
/// counted. Fails with usage if the samples do not differ.
[[nodiscard]] Result<Fit> fit_kohonen(const FitInput& set, const HyperParameters& parameters,
                                      const MethodOptions& options);

}  // namespace gyrotherm
