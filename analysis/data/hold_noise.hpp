/// The noise of a gyro from its own record: Allan deviation over the last hour of each hold.
#pragma once

#include <string>

#include "analysis/data/allan_fit.hpp"
#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"

namespace gyrotherm {

struct HoldNoise {
  AllanCurve curve;       ///< empty if no hold has a stretch long enough for two independent differences
  AllanFit fit;           ///< of that curve; nothing seen if it is empty
  int holds{};            ///< that gave a sample
  int stretches{};        ///< without a gap
  double seconds{};       ///< of all stretches
  double interval_s{};    ///< of the samples
  std::string statement;  ///< what was used, in words
};

/// Of the raw bias, sample by sample, in the last hour of each hold; a record without segments is one hold. A missing
/// sample, a bias that is not known and a new segment each end a stretch. What the temperature still does in a hold is
/// seen as B, K and R, which are then upper limits of the gyro's own, and the statement says so.
[[nodiscard]] HoldNoise noise_of_holds(const Dataset& dataset);

/// The same of the compensated bias. `residual_deg_per_h` is what a model leaves of each cluster's mean; what it takes
/// away is drawn as straight lines from the middle of a cluster to that of the next. Samples beyond the middles of
/// neighbouring clusters, or beside one whose residual is not finite, are missing.
[[nodiscard]] HoldNoise noise_of_compensated_holds(const Dataset& dataset, const Clusters& clusters,
                                                   const Eigen::VectorXd& residual_deg_per_h);

/// Allan deviation of cluster means over a whole record, ramps and all, broken where a cluster is missing or a value is
/// not finite: raw or compensated bias as a user averages it.
[[nodiscard]] AllanCurve allan_curve_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters);

}  // namespace gyrotherm
