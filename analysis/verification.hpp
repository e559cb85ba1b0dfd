/// How good a model is on a record it has not seen.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/clusters.hpp"
#include "analysis/dataset.hpp"
#include "analysis/model.hpp"
#include "analysis/statistics.hpp"
#include "core/result.hpp"

namespace gyrotherm {

struct Verification {
  std::string run_id;
  bool simulated{};
  bool trained_on_this{};  ///< the record is among those the model was fitted to: in-sample, and said so
  Figures raw;
  Figures compensated;
  Figures ramps, holds;                ///< of the compensated bias, apart (count 0 if none)
  Figures corners;                     ///< the first 10 min after each corner
  NoiseFloor floor;                    ///< of the raw bias
  Eigen::VectorXd residual_deg_per_h;  ///< per cluster
  std::vector<SegmentFigures> segments;
  int outside_trained_range{};        ///< clusters with an input beyond the trained range
  std::vector<std::string> warnings;  ///< residual below the floor (over-fit), inputs out of range, …
};

[[nodiscard]] Result<Verification> verify(const Model& model, const Dataset& dataset, const Clusters& clusters);

}  // namespace gyrotherm
