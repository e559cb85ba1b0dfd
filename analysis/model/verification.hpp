// SPDX-License-Identifier: Apache-2.0
/// Verification of a model on a record.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/verdict.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Figures of one segment of the profile.
struct SegmentFigures {
  int segment{};
  std::string name;
  bool hold{};
  double start_s{}, duration_s{};
  double mean_temperature_c{};  ///< first thermometer
  double mean_bias_deg_per_h{};
  data::Figures residual;
};

/// Clusters with inputs outside the trained range, and the policy for them.
struct RangeExceedance {
  Outside policy{};
  /// Clusters with an input outside. With refuse, they are excluded from the residual figures.
  int clusters{};
  /// Term that is farthest outside relative to its range, such as "A-D"; empty if there is none.
  std::string farthest_term;
  /// Distance from the range; 0.1 is a tenth of the trained range.
  double farthest{};
};

void describe(auto& form, Like<RangeExceedance> auto& outside) {
  form("policy", one_of(outside.policy, {Outside::continued, Outside::refuse, Outside::extrapolate}));
  form("clusters", outside.clusters);
  form("farthest_term", outside.farthest_term);
  form("farthest", outside.farthest);
}

/// Prediction minus true bias of a virtual gyro: the error of the model, without effects that no temperature predicts
/// (noise, bias instability, turn-on offset). A constant offset of the training record is not an error of the model;
/// `std` excludes it, `rmse` includes it.
struct TrueBiasError {
  data::Figures figures;
  /// True if the bias reference is a mean of this record, so the mean error has no meaning.
  bool mean_removed{};
};

void describe(auto& form, Like<TrueBiasError> auto& error) {
  describe(form, error.figures);
  form("mean_removed", error.mean_removed);
}

/// Share of cluster means inside the intervals of the model's own budget.
struct Coverage {
  double nominal{};  ///< expected share, 0.95
  double seen{};     ///< observed share
  int clusters{};
  /// Number of independent clusters that would determine the share equally well. An offset that all means share
  /// determines one mean only, so it is at most the effective number of the mean compensated bias.
  double effective{};
  double mean_half_width_deg_per_h{};
};

/// Describes the JSON object, which is the same in all files.
void describe(auto& form, Like<Coverage> auto& coverage) {
  form("nominal", coverage.nominal);
  form("seen", coverage.seen);
  form("clusters", coverage.clusters);
  form("effective", coverage.effective);
  form("mean_half_width_deg_per_h", coverage.mean_half_width_deg_per_h);
}

/// Cluster means of the stream's residual bias, and the residual bias of the same clusters without the stream's lag
/// (aligned). Includes only clusters with a streamed value in every second.
struct StreamResult {
  data::Figures residual, aligned;
  std::optional<TrueBiasError> to_truth, aligned_to_truth;  ///< absent for a real rig
};

void describe(auto& form, Like<StreamResult> auto& streamed) {
  form("residual", streamed.residual);
  form("aligned", streamed.aligned);
  form("to_truth", streamed.to_truth);
  form("aligned_to_truth", streamed.aligned_to_truth);
}

/// Residual bias of a record, in total and in parts; figures in °/h.
struct Verification {
  std::string run_id;
  /// Identity of the gyro, as far as the record states it.
  std::string identity;
  bool simulated{};
  /// True if the model was fitted to this record, so the figures are in-sample.
  bool trained_on_this{};
  /// Set if rows of the record are in a training record of another file. Implies trained_on_this.
  bool has_training_rows{};
  std::string bias_zero;
  /// True if the bias reference is a mean of this record, so the zero of the bias is unknown.
  bool has_own_reference{};
  /// Raw and compensated bias of the same clusters, those with a residual.
  data::Figures raw, compensated;
  /// Figures of the compensated bias in ramps and holds; the count is 0 if there are none.
  data::Figures ramps, holds;
  /// Figures of the first 10 min after each corner, where the temperature profile changes its slope.
  data::Figures corners;
  /// Virtual rig only; the same clusters as `compensated`.
  std::optional<TrueBiasError> to_truth;
  data::NoiseFloor floor;  ///< raw bias
  /// Effective parameters of the model; 0 if unknown.
  double effective_parameters{};
  /// floor·√(1 − p/n), °/h, with n the number of clusters that the model was fitted to in all records: the residual STD
  /// expected from noise only. NaN if the model was not trained on this record or p is unknown.
  double expected_in_sample_std{};
  /// Residual of each cluster; NaN where the model refuses.
  Eigen::VectorXd residual_deg_per_h;
  std::vector<SegmentFigures> segments;
  RangeExceedance outside;
  /// Empty for a model without an uncertainty, and for a record whose bias reference is its own mean: the unknown
  /// constant in its residual would decide which means lie inside their intervals.
  std::optional<Coverage> coverage;
  /// Verdict on the gain and the intervals, on the clusters with a residual.
  Verdict verdict;
  /// Empty until the caller adds the result of evaluate_stream().
  std::optional<StreamResult> streamed;
  /// No gain, intervals that do not hold, over-fit (residual below the noise floor), inputs out of range and others.
  std::vector<std::string> warnings;
};

/// Warning of a model's results on a record on which it was trained.
inline constexpr const char* kTrainedOnThisWarning =
    "the model was trained on this record: the results are in-sample and not a verification";

/// Warning of a model's results on a virtual run with the id of its training record. The id is derived from profile,
/// seed and day, so the record may be another file.
inline constexpr const char* kTrainedOnThisVirtualRunWarning =
    "the model was trained on a virtual run of the same profile, seed and day: the results are in-sample and not a "
    "verification";

/// Returns the error of predictions relative to the true bias, given the residual of each cluster's mean. Uses the
/// clusters with a residual. No value if the truth is unknown.
[[nodiscard]] std::optional<TrueBiasError> compute_true_bias_error(const data::Dataset& dataset,
                                                                   const data::Clusters& clusters,
                                                                   const Eigen::VectorXd& residual_deg_per_h);

/// Compensates the record's clusters and evaluates the residual bias. Fails with usage if the clusters lack a
/// thermometer that the model needs, or if the model refuses every cluster.
[[nodiscard]] Result<Verification> verify(const Model& model, const data::Dataset& dataset,
                                          const data::Clusters& clusters, Outside outside = Outside::continued);

/// Streams the record through the model second by second, like a navigation computer, and evaluates the result:
/// `compensate` and the C export use only past readings and therefore lag. `aligned_residual_deg_per_h` is a result of
/// verify(). Fails with usage if rows are not one per second, if the record lacks a thermometer that the model needs,
/// or if no cluster has a value in every second.
[[nodiscard]] Result<StreamResult> evaluate_stream(const Model& model, const data::Dataset& dataset,
                                                   const data::Clusters& clusters,
                                                   const Eigen::VectorXd& aligned_residual_deg_per_h,
                                                   Outside outside = Outside::continued);

/// Scatter of the means of whole runs, which a single run cannot reveal: type A, from two or more runs.
struct RunScatter {
  int runs{};
  /// Mean compensated bias of each run, averaged over the runs.
  double mean_deg_per_h{};
  /// Standard deviation of one run's mean.
  double std_deg_per_h{};
  int degrees_of_freedom{};
  /// std times Student's t: the means of 95 % of single runs are within this distance of the true mean.
  double expanded_deg_per_h{};
};

void describe(auto& form, Like<RunScatter> auto& between) {
  form("runs", between.runs);
  form("mean_deg_per_h", between.mean_deg_per_h);
  form("std_deg_per_h", between.std_deg_per_h);
  form("degrees_of_freedom", between.degrees_of_freedom);
  form("U_deg_per_h", between.expanded_deg_per_h);
}

/// Computes the scatter of the runs that the model was not trained on, each counted once; no value for fewer than two.
/// A run with its own mean as bias reference is excluded, because its difference from other runs was removed. No value
/// if two runs have different bias references or different gyros.
[[nodiscard]] std::optional<RunScatter> compute_run_scatter(const std::vector<Verification>& verifications);

}  // namespace gyrotherm::model
