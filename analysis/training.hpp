/// The paper's §3.3 from clusters to a model: correlate, select, scale, tune by swarm on held-out cycles, fit.
#pragma once

#include <string>
#include <vector>

#include "analysis/clusters.hpp"
#include "analysis/dataset.hpp"
#include "analysis/model.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"

namespace gyrotherm {

struct TrainingOptions {
  std::string inputs;  ///< multi-point | multi-point-t | three-point | seven-point | terms, comma separated; empty:
                       ///< what the method is published with
  std::string method = "svr";  ///< a name of the table of methods (method.hpp)
  double threshold = 0.90;     ///< of |r|, multi-point only
  bool quick = false;          ///< a swarm of 8 particles and 6 iterations
  TuningOptions tuning;
  std::string program_version;
};

/// Trains on the clusters of all datasets together (they must have the same thermometers). Folds are the cycles; a
/// record without at least two is cut into four consecutive blocks. Selection and scaling are fitted inside each fold.
[[nodiscard]] Result<Model> train(const std::vector<Dataset>& datasets, const std::vector<Clusters>& clusters,
                                  const TrainingOptions& options, const ProgressSink& progress = {});

}  // namespace gyrotherm
