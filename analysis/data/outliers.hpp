// SPDX-License-Identifier: Apache-2.0
/// Values that lie so far from their neighbours that they are no noise of the gyro: spikes of a line, codes of a
/// logger.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"

namespace gyrotherm::data {

/// A value is an outlier beyond so many robust standard deviations (1.4826 times the median absolute deviation).
inline constexpr double kOutlierSigmas = 8;

/// Indices of the values further than kOutlierSigmas from the median; NaN is none. Empty where fewer than 8 values are
/// known, or where half of them are equal.
[[nodiscard]] std::vector<Eigen::Index> outliers_of(const Eigen::Ref<const Eigen::VectorXd>& values);

/// A sample of the bias that is none of its neighbours' kind.
struct Spike {
  Eigen::Index row{};
  double time_s{};
  double size_deg_per_h{};  ///< from the median of the 15 samples around it
};

/// Samples whose bias lies further than kOutlierSigmas from the median of the 15 samples around, by the spread of all
/// such differences. A step of 8 samples and more is no spike.
[[nodiscard]] std::vector<Spike> find_spikes(const Dataset& dataset);

/// Makes their bias missing, so that the clusters they lie in are left out.
void remove(Dataset& dataset, const std::vector<Spike>& spikes);

/// "20 samples of the bias are outliers: -1000 °/h at 120 s, …"; of many the first five.
[[nodiscard]] std::string describe(const std::vector<Spike>& spikes);

/// The clusters whose residual is an outlier: "3 clusters have an outlying held-out residual: 12.5 °/h at 3600 s, …";
/// empty: there is none.
[[nodiscard]] std::string describe_outlying_clusters(const Clusters& clusters,
                                                     const Eigen::Ref<const Eigen::VectorXd>& residual_deg_per_h);

}  // namespace gyrotherm::data
