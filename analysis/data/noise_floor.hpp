/// The floor of a record: what no compensation of it can honestly go below.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/statistics.hpp"

namespace gyrotherm {

/// The last hour of each hold tells of the gyro's own noise: what the temperature still does is slow by then.
inline constexpr double kQuietSeconds = 3600;

/// σ² = ½·mean[(b_{k+1} − b_k)²] over neighbouring clusters inside the last hour of each hold; NaN if there is none.
/// Only clusters wholly inside the hold count; the hour is counted back from the end of the last one. A record without
/// segments is one hold. It does not see bias instability slower than some minutes.
struct NoiseFloor {
  double deg_per_h{};
  int differences{};
  double error_deg_per_h{};  ///< standard error for white noise, whose neighbouring differences are correlated by −½
};
[[nodiscard]] NoiseFloor noise_floor(const Clusters& clusters, const std::vector<RunInfo::SegmentInfo>& segments);

/// What a fit of `effective_parameters` p to n independent clusters leaves of noise alone: floor·√(1 − p/n). NaN where
/// p is not known (0 or NaN) or not below n.
[[nodiscard]] double expected_in_sample_std(const NoiseFloor& floor, double effective_parameters, int clusters);

/// A warning if the residual's STD is below the floor by more than the error bar of their difference, two standard
/// errors. `effective_parameters` of a residual that is in-sample, else 0: the warning then also says what they
/// explain.
[[nodiscard]] std::optional<std::string> over_fit_warning(const Figures& residual, const NoiseFloor& floor,
                                                          double effective_parameters);

}  // namespace gyrotherm
