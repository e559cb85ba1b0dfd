// SPDX-License-Identifier: Apache-2.0
/// The noise of a gyro from the holds of its own record: the floor of its cluster means, and the Allan deviation over
/// the last hour of each hold.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/allan.hpp"
#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/statistics.hpp"

namespace gyrotherm::data {

/// The last hour of each hold tells of the gyro's own noise: what the temperature still does is slow by then.
inline constexpr double kQuietSeconds = 3600;

/// The noise floor σ of cluster means: σ² = mean[(b_{k+2} − 2b_{k+1} + b_k)²]/6 over three neighbouring clusters inside
/// the last hour of each hold, the Hadamard variance at the length of a cluster (NIST SP 1065), which is the
/// Allan variance of white noise and does not see a drift that is steady over 300 s, as the holds of a random program
/// still have. Only clusters wholly inside the hold count; the hour is counted back from the end of the last one. A
/// record that names no hold has no floor: what its bias does between neighbours may be temperature. The floor does not
/// see bias instability slower than some minutes.
///
/// Of a gyro whose pulses are counted neighbouring means share the error of the angle between them, q/√12 of a pulse of
/// q: a mean has 2/12·q²/τ² of it, and mean(Δ²)/6 has 20/6 in the place of the 2. The difference, q²/(9τ²), is taken
/// away; what is left is no less than 6/10 of it, which is all that there is of counting alone.
struct NoiseFloor {
  double deg_per_h{};  ///< NaN where there is none
  int differences{};
  double error_deg_per_h{};    ///< standard error for white noise; NaN where there is none
  std::string statement = {};  ///< what was used, or why there is none, in words
};
/// `step_deg_per_h`: what one pulse in a second is; 0: no pulses are counted.
[[nodiscard]] NoiseFloor noise_floor(const Clusters& clusters,
                                     const std::vector<record::RunInfo::SegmentInfo>& segments,
                                     double step_deg_per_h = 0);
/// … of the clusters of this record.
[[nodiscard]] inline NoiseFloor noise_floor(const Clusters& clusters, const Dataset& dataset) {
  return noise_floor(clusters, dataset.segments, dataset.step_deg_per_h);
}

/// What a fit of `effective_parameters` p to n independent clusters leaves of noise alone: floor·√(1 − p/n). NaN where
/// p is not known (0 or NaN) or not below n.
[[nodiscard]] double expected_in_sample_std(const NoiseFloor& floor, double effective_parameters, int clusters);

/// Warns if the residual's STD is below the floor by more than the error bar of their difference, two standard
/// errors. `effective_parameters` of a residual that is in-sample, else 0: the warning then also says what they
/// explain.
[[nodiscard]] std::optional<std::string> over_fit_warning(const Figures& residual, const NoiseFloor& floor,
                                                          double effective_parameters);

/// The Allan deviation of a record's holds, and what it was made of.
struct HoldNoise {
  AllanCurve curve;       ///< doubling τ, and τ = 100 s; empty if no stretch has two independent differences
  AllanFit fit;           ///< of its points of doubling τ; nothing seen if it is empty
  int holds{};            ///< that gave a sample
  int stretches{};        ///< without a gap
  double seconds{};       ///< of all stretches
  double interval_s{};    ///< of the samples
  std::string statement;  ///< what was used, in words
};

/// The σ of the fit at each point of the curve.
[[nodiscard]] std::vector<double> fitted_deg_per_h(const HoldNoise& noise);

void describe(auto& form, Like<HoldNoise> auto& noise) {
  form("statement", noise.statement);
  form("interval_s", noise.interval_s);
  form("holds", noise.holds);
  form("stretches", noise.stretches);
  form("seconds", noise.seconds);
  form("curve", noise.curve);
  form("coefficients", noise.fit);
  form.derived("fitted_deg_per_h", fitted_deg_per_h(noise));
  form("lowest_tau_s", noise.fit.lowest_tau_s);
  form("misfit", noise.fit.misfit);
}

/// The noise of the raw bias, sample by sample, in the last hour of each hold; nothing of a record that names no hold.
/// A missing sample, a bias that is not known and a new segment each end a stretch. What the temperature still does in
/// a hold is seen as B, K and R, which are then upper limits of the gyro's own, and the statement says so.
[[nodiscard]] HoldNoise noise_of_holds(const Dataset& dataset);
/// The same of those samples alone that lie in one of these clusters.
[[nodiscard]] HoldNoise noise_of_holds(const Dataset& dataset, const Clusters& clusters);

/// The noise of the compensated bias in the same stretches. `residual_deg_per_h` is what a model leaves of each
/// cluster's mean; what it takes away is drawn as straight lines from the middle of a cluster to that of the next.
/// Samples beyond the middles of neighbouring clusters, or beside one whose residual is not finite, are missing.
[[nodiscard]] HoldNoise noise_of_compensated_holds(const Dataset& dataset, const Clusters& clusters,
                                                   const Eigen::VectorXd& residual_deg_per_h);

/// The Allan deviation of cluster means over a whole record, ramps and all, broken where a cluster is missing or a
/// value is not finite: raw or compensated bias as a user averages it.
[[nodiscard]] AllanCurve allan_curve_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters);

}  // namespace gyrotherm::data
