// SPDX-License-Identifier: Apache-2.0
/// Detection of outliers: values too far from their neighbours to be gyro noise, such as spikes on a line or error
/// codes of a logger.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"

namespace gyrotherm::data {

/// Outlier threshold in robust standard deviations (1.4826 times the median absolute deviation).
inline constexpr double kOutlierSigmas = 8;

/// Returns the indices of values further than kOutlierSigmas from the median. NaN is ignored. Returns no indices if
/// fewer than 8 values are known or if half of them are equal.
[[nodiscard]] std::vector<Eigen::Index> find_outliers(const Eigen::Ref<const Eigen::VectorXd>& values);

/// Sample of the bias that differs strongly from its neighbours.
struct Spike {
  Eigen::Index row{};
  double time_s{};
  /// Difference from the median of the 15 samples around it.
  double size_deg_per_h{};
};

/// Finds samples with a bias further than kOutlierSigmas from the median of the 15 samples around them. Sigma is the
/// robust spread of all such differences. A step that lasts 8 samples or more is not a spike.
[[nodiscard]] std::vector<Spike> find_spikes(const Dataset& dataset);

/// Marks the bias of the spikes as missing. make_clusters() then drops their clusters.
void remove(Dataset& dataset, const std::vector<Spike>& spikes);

/// Describes the first five spikes: "20 samples of the bias are outliers: -1000 °/h at 120 s, …".
[[nodiscard]] std::string describe(const std::vector<Spike>& spikes);

/// Describes the clusters with an outlying residual: "3 clusters have an outlying held-out residual: 12.5 °/h at 3600
/// s, …". Returns an empty string if there are none.
[[nodiscard]] std::string describe_outlying_clusters(const Clusters& clusters,
                                                     const Eigen::Ref<const Eigen::VectorXd>& residual_deg_per_h);

}  // namespace gyrotherm::data
