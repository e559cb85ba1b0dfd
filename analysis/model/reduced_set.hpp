// SPDX-License-Identifier: Apache-2.0
/// Fewer vectors at a stated loss: a sum of Gaussians projected onto those of a few of its centres.
///
/// In the space of the kernel the function f = Σ β_i k(x_i, ·) is nearest to the span of the centres kept, R, at
/// K_RR β′ = K_R· β (Burges 1996; Schölkopf et al. 1999, §III). Centres are taken one by one, each time the one that
/// then leaves the least: the residual at it, squared, over what of its own kernel function the others do not span
/// (orthogonal matching pursuit; a pivoted Cholesky factorisation guided by the residual). Since k(z, z) = 1, the norm
/// of what is left bounds the change at every z.
#pragma once

#include <optional>

#include "analysis/data/clusters.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// How far a model is to be reduced; exactly one of the two is given.
struct ReducedSetGoal {
  std::optional<int> vectors = {};                  ///< at most so many, at least 1
  std::optional<double> max_change_deg_per_h = {};  ///< as few as keep every training cluster within this, above 0
};

/// Returns the model with fewer vectors, its `reduction` set and all else as it was: its figures are those of the full
/// function. Where all vectors are needed it keeps them as they are, at no loss. Fails with usage: a goal that is none,
/// a function that is no sum of Gaussians of one width, a model that has been reduced before, clusters without its
/// thermometers or without a value.
[[nodiscard]] Result<Model> reduce(const Model& model, const data::Clusters& training, const ReducedSetGoal& goal);

}  // namespace gyrotherm::model
