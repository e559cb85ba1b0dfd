// SPDX-License-Identifier: Apache-2.0
/// Noise of a gyro measured in the holds of its own record: the noise floor of its cluster means, and the Allan
/// deviation over the last hour of each hold.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/allan.hpp"
#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/statistics.hpp"

namespace gyrotherm::data {

/// Length of the quiet end of each hold, from which the gyro noise is estimated. The temperature changes only slowly by
/// then.
inline constexpr double kQuietSeconds = 3600;

/// Noise floor σ of cluster means, from second differences of three neighbouring clusters in the last hour of each
/// hold: σ² = mean[(b_{k+2} − 2b_{k+1} + b_k)²]/6. σ² is the Hadamard variance at the cluster length (NIST SP 1065).
/// For white noise it equals the Allan variance. A drift that is steady over 300 s, as in the holds of a random
/// program, does not affect it. Only clusters wholly inside the hold are used. The hour ends with the last of these
/// clusters. A record without named holds has no noise floor, because its bias may change with temperature between
/// neighbours. Bias instability slower than some minutes does not contribute.
///
/// If pulses are counted, two neighbouring means share the quantisation error of the angle at their common boundary,
/// q/√12 for a pulse of size q. This error contributes 2/12·q²/τ² to the variance of a mean and 20/6·q²/(12τ²) to
/// mean(Δ²)/6. The difference, q²/(9τ²), is subtracted. The result is limited to at least 6/10 of mean(Δ²)/6, the value
/// for pure quantisation.
struct NoiseFloor {
  /// Noise floor. NaN if there is none.
  double deg_per_h{};
  int differences{};
  /// Standard error for white noise. NaN if there is no noise floor.
  double error_deg_per_h{};
  /// Summary of the data used, or the reason for a missing noise floor.
  std::string statement = {};
};
/// Computes the noise floor. `step_deg_per_h` is the rate of one pulse per second, or 0 if pulses are not counted.
[[nodiscard]] NoiseFloor noise_floor(const Clusters& clusters,
                                     const std::vector<record::RunInfo::SegmentInfo>& segments,
                                     double step_deg_per_h = 0);
/// Computes the noise floor of the clusters of a record.
[[nodiscard]] inline NoiseFloor noise_floor(const Clusters& clusters, const Dataset& dataset) {
  return noise_floor(clusters, dataset.segments, dataset.step_deg_per_h);
}

/// Estimates the white noise σ of cluster means from the residual of a model over a whole record, for a record without
/// holds: second differences of neighbouring residuals, as in noise_floor(). They are insensitive to errors of the
/// model that change slowly. Differences above four robust standard deviations (1.4826 times the median magnitude), as
/// at the borders of folds, are not used. NaN values are missing.
[[nodiscard]] NoiseFloor residual_noise(const Clusters& clusters, const Eigen::VectorXd& residual_deg_per_h,
                                        double step_deg_per_h = 0);

/// Returns whether a record has a hold.
[[nodiscard]] bool has_hold(const Dataset& dataset);

/// Returns the STD expected in-sample if the residual is only noise: floor·√(1 − p/n) for a fit with
/// `effective_parameters` p to n independent clusters. Returns NaN if p is unknown (0 or NaN) or not below n.
[[nodiscard]] double expected_in_sample_std(const NoiseFloor& floor, double effective_parameters, int clusters);

/// Returns a warning if the STD of the residual is below the noise floor by more than two standard errors of their
/// difference. Pass `effective_parameters` for an in-sample residual and 0 otherwise. If `effective_parameters` is
/// above 0, the warning includes the STD that the parameters explain.
[[nodiscard]] std::optional<std::string> over_fit_warning(const Figures& residual, const NoiseFloor& floor,
                                                          double effective_parameters);

/// Allan deviation of the holds of a record, and the data used for it.
struct HoldNoise {
  /// Points at doubling τ and at τ = 100 s. Empty if no stretch has two independent differences.
  AllanCurve curve;
  /// Fit to the points at doubling τ. No term is significant if the curve is empty.
  AllanFit fit;
  /// Number of holds with at least one sample.
  int holds{};
  /// Number of stretches without a gap, and their total length.
  int stretches{};
  double seconds{};
  double interval_s{};  ///< sample interval
  /// Summary of the data used.
  std::string statement;
};

/// Returns σ of the fit at each point of the curve.
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

/// Computes the Allan deviation of the raw bias, sample by sample, in the last hour of each hold. The result is empty
/// if the record has no hold. A missing sample, an unknown bias and a new segment each end a stretch. Temperature
/// changes that remain in a hold increase B, K and R. These three are therefore upper limits for the gyro itself, and
/// the statement notes this.
[[nodiscard]] HoldNoise measure_hold_noise(const Dataset& dataset);
/// Computes the Allan deviation in the same way from the samples in the given clusters only.
[[nodiscard]] HoldNoise measure_hold_noise(const Dataset& dataset, const Clusters& clusters);

/// Computes the Allan deviation of the compensated bias in the same stretches. `residual_deg_per_h` is the residual of
/// a model for each cluster mean. The compensation is interpolated linearly between the middles of neighbouring
/// clusters. Samples outside such an interval, or next to a residual that is not finite, are treated as missing.
[[nodiscard]] HoldNoise measure_compensated_hold_noise(const Dataset& dataset, const Clusters& clusters,
                                                       const Eigen::VectorXd& residual_deg_per_h);

/// Computes the Allan deviation of cluster means over a whole record including its ramps, for raw or compensated bias.
/// Missing clusters and values that are not finite end a stretch.
[[nodiscard]] AllanCurve cluster_allan_curve(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters);

}  // namespace gyrotherm::data
