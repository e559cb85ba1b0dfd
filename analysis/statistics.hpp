/// The figures by which a residual is judged: eq. 11 and what it hides; and the noise floor of the record itself.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/clusters.hpp"

namespace gyrotherm {

/// Of cluster means, °/h. `std` is eq. 11 (N − 1), 0 of a single value; all are 0 of none.
struct Figures {
  double std{}, mean{}, rmse{}, max_abs{};
  int count{};
};
[[nodiscard]] Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values);

/// Both ways of saying "improvement" (errata 1.1).
struct Improvement {
  double three_point_from_original{};  ///< 1 − s_three/s_raw
  double multi_point_from_original{};  ///< 1 − s_multi/s_raw
  double paper_ratio{};  ///< (multi − three)/three of the two above: the paper's "improvement from traditional method"
  double residual_reduction{};  ///< 1 − s_multi/s_three
};
[[nodiscard]] Improvement improvement(double std_raw, double std_three_point, double std_multi_point);

/// σ² = ½·mean[(b_{k+1} − b_k)²] over neighbouring clusters inside the last hour of each hold (physics of the noise
/// floor); NaN if there is none. Only clusters wholly inside the hold count; the hour is counted back from the end of
/// the last one. A record without segments is one hold. It does not see bias instability slower than some minutes.
struct NoiseFloor {
  double deg_per_h{};
  int differences{};
};
[[nodiscard]] NoiseFloor noise_floor(const Clusters& clusters, const std::vector<RunInfo::SegmentInfo>& segments);

/// Figures of one stretch of the profile.
struct SegmentFigures {
  int segment{};
  std::string name;
  bool hold{};
  double start_s{}, duration_s{};
  double mean_temperature_c{};  ///< of the first thermometer
  double mean_bias_deg_per_h{};
  Figures residual;
};

/// Overlapping Allan deviation of evenly spaced values at averaging `m` (NIST SP 1065).
[[nodiscard]] double overlapping_allan_deviation(const Eigen::Ref<const Eigen::VectorXd>& values, int m);

}  // namespace gyrotherm
