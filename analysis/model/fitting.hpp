/// One training set made ready, and one function fitted to it: what the final model and every fold have in common.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/model/inputs.hpp"
#include "analysis/model/model.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Selection, scaling and target units, all learnt from the training clusters alone.
struct Preparation {
  std::vector<Term> terms;
  Selection selection;
  Scaling scaling;
  double target_mean_deg_per_h{};
  double target_std_deg_per_h{};
};

/// Fails with usage if an input or the bias does not vary over the training clusters, or as choose_inputs does. The
/// lesson's folds are for a selection that holds out; nothing else asks them.
[[nodiscard]] Result<Preparation> prepare(const InputPlan& plan, const TrainingSet& training);

/// Scaled inputs of any clusters.
[[nodiscard]] Result<SampleMatrix> scaled_inputs(const Preparation& preparation, const Clusters& clusters);
/// Bias in units of the target's training STD from its training mean.
[[nodiscard]] Eigen::VectorXd scaled_target(const Preparation& preparation, const Clusters& clusters);

/// The model that preparation and fit make, without what is known of its making.
[[nodiscard]] Model assemble(const Preparation& preparation, Fit fit);

}  // namespace gyrotherm
