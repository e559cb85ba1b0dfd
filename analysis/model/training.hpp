/// The paper's §3.3 from clusters to a model: correlate, select, scale, tune by swarm on held-out cycles, fit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/folds.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/selection.hpp"
#include "core/result.hpp"

namespace gyrotherm {

struct TrainingOptions {
  std::string inputs;                   ///< words and terms (inputs.hpp); empty: what the method is published with
  std::string method = "svr";           ///< a name of the table of methods (method.hpp)
  std::optional<SelectionRule> select;  ///< nothing: only multi-point selects, by |r| > 0.90
  FoldOptions folds;
  std::optional<FoldPlan> fold_plan;  ///< instead of `folds`, each cluster held out once: what users are not offered
  bool nested = false;                ///< also Model.nested_leave_cycle_out
  bool quick = false;                 ///< a swarm of 8 particles and 6 iterations
  TuningOptions tuning;
  std::string program_version;
};

/// Trains on the clusters of all datasets together (they must have the same thermometers). Selection and scaling are
/// fitted inside each fold. Clusters without a value of every input are left out, and a warning says how many.
[[nodiscard]] Result<Model> train(const std::vector<Dataset>& datasets, const std::vector<Clusters>& clusters,
                                  const TrainingOptions& options, const ProgressSink& progress = {});

}  // namespace gyrotherm
