// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/outliers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gyrotherm::data {
namespace {

/// Returns a bias that follows a slow oven, with noise of about 1 °/h.
Dataset noisy(Eigen::Index rows) {
  Dataset dataset;
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  dataset.bias_deg_per_h.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto x = static_cast<double>(i);
    dataset.bias_deg_per_h(i) = 100 * std::sin(x / 300) + 2 * std::fmod(std::abs(std::sin(x * 1.37) * 43758.5), 1.0);
  }
  return dataset;
}

TEST(Outliers, FindsSpikesOfAnySize) {
  for (const double size : {40., -1000., 1e6}) {
    Dataset dataset = noisy(2000);
    for (const Eigen::Index row : {0, 77, 78, 1999}) dataset.bias_deg_per_h(row) += size;
    const auto spikes = find_spikes(dataset);
    ASSERT_EQ(spikes.size(), 4u) << size;
    EXPECT_EQ(spikes[2].row, 78);
    EXPECT_EQ(spikes[2].time_s, 78);
    EXPECT_NEAR(spikes[2].size_deg_per_h, size, 3);
    remove(dataset, spikes);
    EXPECT_TRUE(std::isnan(dataset.bias_deg_per_h(1999)));
    EXPECT_TRUE(find_spikes(dataset).empty());
  }
}

TEST(Outliers, IgnoresNoiseRampsStepsAndCounts) {
  Dataset step = noisy(2000), counts = noisy(2000), turned = noisy(2000);
  step.bias_deg_per_h.tail(1000).array() += 500;
  counts.bias_deg_per_h = counts.bias_deg_per_h.array().round();
  turned.bias_deg_per_h.segment(500, 20).array() -= 21;
  for (const Dataset& dataset : {noisy(2000), step, counts, turned}) EXPECT_TRUE(find_spikes(dataset).empty());
  EXPECT_TRUE(find_spikes(noisy(5)).empty());
}

TEST(Outliers, NamesClustersWithOutlyingResidual) {
  Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(50, 0, 4900);
  Eigen::VectorXd residual(50);
  for (Eigen::Index i = 0; i < 50; ++i) residual(i) = std::sin(static_cast<double>(i));
  EXPECT_EQ(describe_outlying_clusters(clusters, residual), "");
  residual(7) = 40;
  residual(8) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(describe_outlying_clusters(clusters, residual),
            "1 clusters have an outlying held-out residual: 40 °/h at 700 s");
}

}  // namespace
}  // namespace gyrotherm::data
