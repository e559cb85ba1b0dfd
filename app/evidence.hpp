/// Records, ready for analysis.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/clusters.hpp"
#include "analysis/dataset.hpp"
#include "analysis/model.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// A record's samples and their 100-s means.
struct Evidence {
  Dataset dataset;
  Clusters clusters;
};

/// First and one past the last cluster, of those that a record has.
struct ClusterRange {
  Eigen::Index first{}, end{};
};
/// "0:14" → the clusters 0 … 13; "" → all of them. Fails with usage.
[[nodiscard]] Result<std::optional<ClusterRange>> parse_cluster_range(const std::string& text);

/// With a range, only those clusters. Fails like load_dataset and make_clusters, or with usage if the record has not
/// that many.
[[nodiscard]] Result<Evidence> load_evidence(const std::string& path, const std::optional<ClusterRange>& range = {});

/// Fails with bad_file.
[[nodiscard]] Result<Model> load_model(const std::string& path);

}  // namespace gyrotherm
