// SPDX-License-Identifier: Apache-2.0
/// How good a model is on a record it has not seen.
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
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// Figures of one stretch of the profile.
struct SegmentFigures {
  int segment{};
  std::string name;
  bool hold{};
  double start_s{}, duration_s{};
  double mean_temperature_c{};  ///< of the first thermometer
  double mean_bias_deg_per_h{};
  data::Figures residual;
};

/// Inputs beyond the range in which the model was trained, and what was done with them.
struct OutsideTheRange {
  Outside policy{};
  int clusters{};             ///< with an input outside; with refuse, left out of every figure of the residual
  std::string farthest_term;  ///< "A-D": farthest outside as a part of its range; empty if none is
  double farthest{};          ///< how far: 0.1 is a tenth of its trained range
};

void describe(auto& form, Like<OutsideTheRange> auto& outside) {
  form("policy", one_of(outside.policy, {Outside::continued, Outside::refuse, Outside::extrapolate}));
  form("clusters", outside.clusters);
  form("farthest_term", outside.farthest_term);
  form("farthest", outside.farthest);
}

/// Prediction − true bias of a virtual gyro: what the model gets wrong, free of what no temperature tells of (noise,
/// bias instability, turn-on offset). A constant offset of the training record is no model's fault: `std` is without
/// the mean, `rmse` with it.
struct ErrorToTruth {
  data::Figures figures;
  bool mean_removed{};  ///< the zero of the bias is the record's own, so that its mean says nothing
};

void describe(auto& form, Like<ErrorToTruth> auto& error) {
  describe(form, error.figures);
  form("mean_removed", error.mean_removed);
}

/// How many cluster means lie within the intervals that the model's own budget gives them.
struct Coverage {
  double nominal{};                    ///< the share that should: 0.95
  double seen{};                       ///< the share that does
  int clusters{};                      ///< with an interval
  double effective{};                  ///< as many independent clusters would tell as much of the share
  double mean_half_width_deg_per_h{};  ///< of the intervals
};

/// Its form wherever it is written.
void describe(auto& form, Like<Coverage> auto& coverage) {
  form("nominal", coverage.nominal);
  form("seen", coverage.seen);
  form("clusters", coverage.clusters);
  form("effective", coverage.effective);
  form("mean_half_width_deg_per_h", coverage.mean_half_width_deg_per_h);
}

/// The bias that the stream leaves, in means over the clusters, beside what predictions of the same means leave that
/// are aligned with them: of those clusters alone in which every second has a value.
struct Streamed {
  data::Figures residual, aligned;
  std::optional<ErrorToTruth> to_truth, aligned_to_truth;  ///< a virtual rig's
};

void describe(auto& form, Like<Streamed> auto& streamed) {
  form("residual", streamed.residual);
  form("aligned", streamed.aligned);
  form("to_truth", streamed.to_truth);
  form("aligned_to_truth", streamed.aligned_to_truth);
}

/// What a model leaves of a record's bias, as a whole and in parts; figures in °/h.
struct Verification {
  std::string run_id;
  std::string identity;  ///< which gyro it is of, as far as the record says
  bool simulated{};
  bool trained_on_this{};  ///< the record is among those the model was fitted to: in-sample, and said so
  std::string bias_zero;   ///< what its bias is counted from, in words
  bool zero_is_its_own{};  ///< that is a mean of this record
  data::Figures raw;
  data::Figures compensated;
  data::Figures ramps, holds;            ///< of the compensated bias, apart (count 0 if none)
  data::Figures corners;                 ///< the first 10 min after each corner
  std::optional<ErrorToTruth> to_truth;  ///< a virtual rig's; of the same clusters as `compensated`
  data::NoiseFloor floor;                ///< of the raw bias
  double effective_parameters{};         ///< of the model; 0 if not known
  double expected_in_sample_std{};  ///< floor·√(1 − p/n), °/h, n the clusters that it was fitted to, here or elsewhere:
                                    ///< what they leave of noise alone; NaN if the record was not trained on or p is
                                    ///< not known
  Eigen::VectorXd residual_deg_per_h;  ///< per cluster; NaN where the model refuses
  std::vector<SegmentFigures> segments;
  OutsideTheRange outside;
  std::optional<Coverage> coverage;   ///< nothing if the model says nothing of its uncertainty
  std::optional<Streamed> streamed;   ///< nothing unless as_streamed() was asked
  std::vector<std::string> warnings;  ///< residual below the floor (over-fit), inputs out of range, …
};

/// Returns how far predictions are from the true bias, given what they leave of each cluster's mean: of those clusters
/// at which there is a residual. Nothing where the truth is not known.
[[nodiscard]] std::optional<ErrorToTruth> error_to_truth(const data::Dataset& dataset, const data::Clusters& clusters,
                                                         const Eigen::VectorXd& residual_deg_per_h);

/// Compensates the record's clusters and judges what is left. Fails with usage if they lack a thermometer that the
/// model needs, or the model refuses every cluster.
[[nodiscard]] Result<Verification> verify(const Model& model, const data::Dataset& dataset,
                                          const data::Clusters& clusters, Outside outside = Outside::continued);

/// Streams the record through the model and judges what a navigation computer gets second by second: compensate and the
/// C export see the past alone, and lag. `aligned_residual_deg_per_h` is that of verify(). Fails with usage if rows are
/// not one a second, the model needs a thermometer that the record lacks, or no cluster has a value in every second.
[[nodiscard]] Result<Streamed> as_streamed(const Model& model, const data::Dataset& dataset,
                                           const data::Clusters& clusters,
                                           const Eigen::VectorXd& aligned_residual_deg_per_h,
                                           Outside outside = Outside::continued);

/// Warns if what a model leaves of two or more means has no smaller STD than the raw bias. `leaves` begins the sentence
/// about it, such as "compensated".
[[nodiscard]] std::optional<std::string> no_gain_warning(std::string_view leaves, const data::Figures& left,
                                                         const data::Figures& raw);

/// How the means of whole runs differ, which no single run shows: type A, from two or more.
struct BetweenRuns {
  int runs{};
  double mean_deg_per_h{};  ///< of the runs' means of compensated bias
  double std_deg_per_h{};   ///< of one run's mean
  int degrees_of_freedom{};
  double expanded_deg_per_h{};  ///< std by Student's t: 95 % of single runs' means lie within it of the true mean
};

void describe(auto& form, Like<BetweenRuns> auto& between) {
  form("runs", between.runs);
  form("mean_deg_per_h", between.mean_deg_per_h);
  form("std_deg_per_h", between.std_deg_per_h);
  form("degrees_of_freedom", between.degrees_of_freedom);
  form("U_deg_per_h", between.expanded_deg_per_h);
}

/// Of those runs that the model was not trained on, each counted once; nothing if they are fewer than two. A run whose
/// zero is its own does not count: how it differs from others is what was removed. Nothing if two count their bias from
/// different zeros, or are of different gyros.
[[nodiscard]] std::optional<BetweenRuns> between_runs(const std::vector<Verification>& verifications);

}  // namespace gyrotherm::model
