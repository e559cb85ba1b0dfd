// SPDX-License-Identifier: Apache-2.0
/// Means over 100 s (eq. 11 as corrected in errata 2): what everything after works on.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "core/result.hpp"

namespace gyrotherm::data {

/// The temperatures of whole runs, one run after the other, a row per cluster, of those too in which another reading is
/// missing: what lags are made of where a part of the clusters is looked at.
struct TemperatureHistory {
  Eigen::VectorXd elapsed_s;      ///< since the cluster before it in its run; infinite for the first of a run
  Eigen::MatrixXd temperature_c;  ///< clusters × thermometers; NaN where one of its readings is missing
};

/// The clusters of a record, a row each. Cluster k holds the samples with 100k ≤ t − t_0 < 100(k + 1) s.
struct Clusters {
  double length_s = 100;
  std::vector<std::string> thermometers;
  Eigen::VectorXd start_s;        ///< of each cluster, since the run started
  Eigen::MatrixXd temperature_c;  ///< clusters × thermometers
  /// Causal: (mean of this cluster − mean of the one before)/length, which lags by half a cluster; NaN in the first
  /// cluster of a run and in the first after a gap, where there is none.
  Eigen::MatrixXd rate_c_per_min;
  Eigen::VectorXd bias_deg_per_h;
  Eigen::VectorXd true_bias_deg_per_h;  ///< empty or NaN: not known
  Eigen::VectorXd set_point_c;
  Eigen::VectorXi segment;       ///< of the cluster's first sample
  Eigen::VectorXi last_segment;  ///< of its last sample; another one where a corner lies inside the cluster
  Eigen::VectorXi cycle;
  Eigen::VectorXi samples;            ///< how many are in each
  TemperatureHistory history;         ///< of the whole runs that the clusters are of, for lags
  std::vector<Eigen::Index> moments;  ///< each cluster's row of the history; empty where that is not known
  int dropped_rest{};                 ///< samples after the last whole cluster
  int dropped_gaps{};                 ///< clusters with a missing reading or across a gap
};

/// Whether it is known where in their runs the clusters lie.
[[nodiscard]] bool has_history(const Clusters& clusters);

/// Cuts a record into clusters. In our own records a cluster is whole if each of its seconds has every temperature and
/// the bias; one missing reading drops it. In imported records rows count by their own time, however many there are; a
/// missing reading or no row at all drops the cluster. Fails with usage if no whole cluster remains.
[[nodiscard]] Result<Clusters> make_clusters(const Dataset& dataset, double length_s = 100);

/// Whether twice the Earth's rate lies between some of the clusters and others: it is not known, and the unit is turned
/// around between them.
[[nodiscard]] bool jumps_by_turning(const Dataset& dataset, const Clusters& clusters);

/// A record's samples and their means.
struct RecordedRun {
  Dataset dataset;
  Clusters clusters;
};

/// The clusters at these rows, in order.
[[nodiscard]] Clusters pick(const Clusters& clusters, const std::vector<Eigen::Index>& rows);

/// The clusters of all parts, one part after the other. Fails with usage if thermometers or lengths differ, or there is
/// none.
[[nodiscard]] Result<Clusters> concatenate(const std::vector<Clusters>& parts);

}  // namespace gyrotherm::data
