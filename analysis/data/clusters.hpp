// SPDX-License-Identifier: Apache-2.0
/// Cluster means over 100 s (eq. 11 as corrected in errata 2), the input of all later steps of the analysis.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "core/result.hpp"

namespace gyrotherm::data {

/// Temperatures of whole runs, one run after the other, one row per cluster. Includes clusters with missing readings,
/// so lags can be computed even if only some of the clusters are used.
struct TemperatureHistory {
  /// Time since the previous cluster of the same run. Infinite for the first cluster of a run.
  Eigen::VectorXd elapsed_s;
  /// clusters × thermometers. NaN if a reading is missing.
  Eigen::MatrixXd temperature_c;
};

/// Clusters of a record, one row each. Cluster k holds the samples with 100k ≤ t − t_0 < 100(k + 1) s.
struct Clusters {
  double length_s = 100;
  std::vector<std::string> thermometers;
  /// Time from the start of the run to the start of each cluster.
  Eigen::VectorXd start_s;
  Eigen::MatrixXd temperature_c;  ///< clusters × thermometers
  /// Causal rate: (mean of this cluster − mean of the previous cluster)/length. It lags by half a cluster. NaN in the
  /// first cluster of a run and in the first cluster after a gap.
  Eigen::MatrixXd rate_c_per_min;
  Eigen::VectorXd bias_deg_per_h;
  Eigen::VectorXd true_bias_deg_per_h;  ///< empty or NaN: unknown
  Eigen::VectorXd set_point_c;
  /// Segments of the first and the last sample of each cluster. They differ if a segment ends inside the cluster.
  Eigen::VectorXi segment;
  Eigen::VectorXi last_segment;
  Eigen::VectorXi cycle;
  /// Power-on that precedes each cluster, counted from 0 over all runs of the clusters. The start of a run counts as
  /// one. Empty: a single power-on.
  Eigen::VectorXi power_on;
  /// Number of samples in each cluster.
  Eigen::VectorXi samples;
  /// History of the whole runs that contain the clusters, for lags.
  TemperatureHistory history;
  /// Row of each cluster in the history. Empty if unknown.
  std::vector<Eigen::Index> moments;
  /// Number of samples after the last whole cluster.
  int dropped_rest{};
  /// Number of clusters dropped for a missing reading or a gap.
  int dropped_gaps{};
  /// Number of clusters with all their seconds that were dropped because of each input with missing readings ("the
  /// bias" is one). Clusters that also lack seconds are gaps.
  std::vector<std::pair<std::string, int>> dropped_by_input{};
};

/// Counts the power-ons that precede at least one cluster; 0 without clusters.
[[nodiscard]] int count_power_ons(const Clusters& clusters);

/// Returns whether the position of each cluster in the history of its run is known.
[[nodiscard]] bool has_history(const Clusters& clusters);

/// Averages a record into clusters. In native records a cluster is kept if each of its seconds has every temperature
/// and the bias; one missing reading drops it. In imported records, rows are assigned by their own time stamps and any
/// number of rows is accepted; a cluster with a missing reading or without rows is dropped. Fails with usage if no
/// whole cluster remains.
[[nodiscard]] Result<Clusters> make_clusters(const Dataset& dataset, double length_s = 100);

/// Describes the part of the record that was left out because inputs are missing, with each input and its share of the
/// clusters with all their seconds. Returns an empty text if it is at most 5 %.
[[nodiscard]] std::string describe_left_out(const Clusters& clusters);

/// Returns whether the clusters include both positions of a unit that is turned around while the Earth rate is unknown.
/// The bias then differs by twice the Earth rate between the two positions.
[[nodiscard]] bool jumps_by_turning(const Dataset& dataset, const Clusters& clusters);

/// Samples of a record and their cluster means.
struct RecordedRun {
  Dataset dataset;
  Clusters clusters;
};

/// Returns the clusters at the given rows, in order.
[[nodiscard]] Clusters pick_clusters(const Clusters& clusters, const std::vector<Eigen::Index>& rows);

/// Joins the clusters of all parts in order. Fails with usage if the parts differ in thermometers or cluster length, or
/// if `parts` is empty.
[[nodiscard]] Result<Clusters> concatenate(const std::vector<Clusters>& parts);

}  // namespace gyrotherm::data
