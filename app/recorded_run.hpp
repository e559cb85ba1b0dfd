// SPDX-License-Identifier: Apache-2.0
/// Records, as evidence: seen to be as they were written, and ready for analysis.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/model/model.hpp"
#include "app/command.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// First and one past the last cluster, of those that a record has.
struct ClusterRange {
  Eigen::Index first{}, end{};
};
/// "0:14" → the clusters 0 … 13; "" → all of them. Fails with usage.
[[nodiscard]] Result<std::optional<ClusterRange>> parse_cluster_range(const std::string& text);

/// Fails with bad_file if the record is not as it was written (verify_record), naming the first place that does not
/// fit. With `unverified` it is not looked at, which is said.
[[nodiscard]] Result<void> check_recorded_run(Console& console, const std::string& path, bool unverified);

struct RecordedRunOptions {
  std::optional<ClusterRange> range;  ///< only those clusters
  bool unverified = false;
};
/// Adds the flag --unverified to a command that reads records.
void add_unverified_flag(Command& command, bool& unverified);

/// Fails like check_recorded_run, load_dataset and make_clusters, or with usage if the record has not that many
/// clusters.
[[nodiscard]] Result<data::RecordedRun> load_recorded_run(Console& console, const std::string& path,
                                                          const RecordedRunOptions& options = {});

/// Fails with bad_file.
[[nodiscard]] Result<model::Model> load_model(const std::string& path);

}  // namespace gyrotherm::app
