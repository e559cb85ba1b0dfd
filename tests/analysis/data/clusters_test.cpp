// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/clusters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/analysis/real_records.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

/// Returns `rows` seconds of one thermometer that warms at 0.6 °C/min, with a bias that equals the time in s.
Dataset ramp(Eigen::Index rows) {
  Dataset dataset;
  dataset.path = "ramp.db";
  dataset.thermometers = {"A"};
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  dataset.temperature_c = 20 + 0.01 * dataset.time_s.array();
  dataset.bias_deg_per_h = dataset.time_s;
  dataset.set_point_c = dataset.temperature_c.col(0);
  dataset.segment.setZero(rows);
  dataset.cycle.setZero(rows);
  return dataset;
}

TEST(Clusters, AverageOverOneHundredSecondsAndDropRemainder) {
  const auto clusters = make_clusters(ramp(399));
  ASSERT_TRUE(clusters);
  ASSERT_EQ(clusters->start_s.size(), 3);
  EXPECT_EQ(clusters->dropped_rest, 99);
  EXPECT_EQ(clusters->dropped_gaps, 0);
  EXPECT_DOUBLE_EQ(clusters->bias_deg_per_h(1), 149.5);
  EXPECT_DOUBLE_EQ(clusters->start_s(2), 200);
  EXPECT_EQ(clusters->samples(0), 100);
}

TEST(Clusters, AverageTrueBiasWhenKnown) {
  Dataset dataset = ramp(300);
  EXPECT_TRUE(make_clusters(dataset)->true_bias_deg_per_h.array().isNaN().all());
  const auto unknown = *make_clusters(dataset);
  dataset.true_bias_deg_per_h = 2 * dataset.time_s;
  dataset.true_bias_deg_per_h(250) = std::nan("");
  const auto clusters = make_clusters(dataset);
  ASSERT_EQ(clusters->true_bias_deg_per_h.size(), 3) << "a cluster without true bias is kept";
  EXPECT_DOUBLE_EQ(clusters->true_bias_deg_per_h(1), 2 * 149.5);
  EXPECT_TRUE(std::isnan(clusters->true_bias_deg_per_h(2)));
  EXPECT_DOUBLE_EQ(pick_clusters(*clusters, {1}).true_bias_deg_per_h(0), 2 * 149.5);
  const auto both = concatenate({unknown, *clusters});
  EXPECT_TRUE(std::isnan(both->true_bias_deg_per_h(0)));
  EXPECT_DOUBLE_EQ(both->true_bias_deg_per_h(4), 2 * 149.5);
}

TEST(Clusters, HaveWholeSecondsInNativeRecords) {
  EXPECT_TRUE(make_clusters(ramp(400), 7));
  for (const double length_s : {1.5, 99.5}) {
    const auto refused = make_clusters(ramp(400), length_s);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::usage);
    auto imported = ramp(400);
    imported.imported = true;
    EXPECT_TRUE(make_clusters(imported, length_s));
  }
}

TEST(Clusters, KeepLastClusterWhenExactlyComplete) { EXPECT_EQ(make_clusters(ramp(400))->start_s.size(), 4); }

TEST(Clusters, ComputeCausalRate) {
  const auto clusters = make_clusters(ramp(400));
  EXPECT_TRUE(std::isnan(clusters->rate_c_per_min(0, 0))) << "the first cluster has no rate";
  EXPECT_NEAR(clusters->rate_c_per_min(1, 0), 0.6, 1e-12);
}

TEST(Clusters, DropClusterWithMissingReading) {
  Dataset dataset = ramp(400);
  dataset.temperature_c(150, 0) = std::nan("");
  const auto clusters = make_clusters(dataset);
  ASSERT_EQ(clusters->start_s.size(), 3);
  EXPECT_EQ(clusters->dropped_gaps, 1);
  EXPECT_DOUBLE_EQ(clusters->start_s(1), 200);
  EXPECT_TRUE(std::isnan(clusters->rate_c_per_min(1, 0))) << "the first cluster after a gap has no rate";
  EXPECT_NEAR(clusters->rate_c_per_min(2, 0), 0.6, 1e-12);
}

TEST(Clusters, DropClustersAcrossGap) {
  Dataset dataset = ramp(400);
  // Omits samples 150…279.
  dataset.time_s.tail(250).array() += 130;
  const auto clusters = make_clusters(dataset);
  ASSERT_TRUE(clusters);
  EXPECT_EQ(clusters->start_s, (Eigen::Vector3d{0, 300, 400}));
  EXPECT_EQ(clusters->dropped_gaps, 2);
  EXPECT_EQ(clusters->dropped_rest, 30);
}

/// The bias is missing in seven clusters, of which five also lack a second.
TEST(Clusters, CountMissingInputsOnlyWhereNoSecondIsMissing) {
  Dataset dataset = ramp(1200);
  dataset.bias_deg_per_h.segment(200, 700).setConstant(std::nan(""));
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < 1200; ++row)
    if (row < 400 || row >= 900 || row % 100 != 50) rows.push_back(row);
  Dataset gaps = ramp(static_cast<Eigen::Index>(rows.size()));
  gaps.time_s = dataset.time_s(rows).eval();
  gaps.temperature_c = dataset.temperature_c(rows, Eigen::all).eval();
  gaps.bias_deg_per_h = dataset.bias_deg_per_h(rows).eval();
  const auto clusters = make_clusters(gaps);
  ASSERT_TRUE(clusters);
  EXPECT_EQ(clusters->start_s.size(), 5);
  EXPECT_EQ(clusters->dropped_gaps, 7);
  ASSERT_EQ(clusters->dropped_by_input.size(), 1u);
  EXPECT_EQ(clusters->dropped_by_input.front(), std::pair(std::string("the bias"), 2));
  EXPECT_EQ(describe_left_out(*clusters),
            "a part of the record is left out because values are missing: the bias in 2 clusters (28.6 %)");
}

TEST(Clusters, LeaveOutAtMostTheWholeRecord) {
  for (const Eigen::Index whole : {1, 5, 11}) {
    Dataset dataset = ramp(1200);
    dataset.temperature_c.bottomRows(1200 - 100 * whole).setConstant(std::nan(""));
    const auto clusters = make_clusters(dataset);
    ASSERT_TRUE(clusters);
    ASSERT_EQ(clusters->dropped_by_input.size(), 1u);
    EXPECT_EQ(clusters->dropped_by_input.front().second, 12 - whole);
    EXPECT_EQ(clusters->history.elapsed_s.size(), 12) << "the denominator of the share";
  }
}

TEST(Clusters, FailWithoutCompleteCluster) {
  EXPECT_EQ(make_clusters(ramp(99)).error().kind, FaultKind::usage);
  EXPECT_EQ(make_clusters(ramp(0)).error().kind, FaultKind::usage);
}

TEST(Clusters, NameDeadThermometerInFault) {
  Dataset dataset = ramp(400);
  dataset.thermometers = {"A", "B", "self"};
  dataset.temperature_c = dataset.temperature_c.col(0).replicate(1, 3).eval();
  dataset.temperature_c.rightCols(2).setConstant(std::nan(""));
  EXPECT_EQ(make_clusters(dataset).error().what, "contains no complete cluster of 100 s; no row has a value of B");
  EXPECT_EQ(make_clusters(ramp(99)).error().what, "contains no complete cluster of 100 s");
  dataset.bias_deg_per_h.setConstant(std::nan(""));
  EXPECT_TRUE(make_clusters(dataset).error().what.ends_with("of B, the bias"));
}

TEST(Clusters, RecordSegmentChangeInsideCluster) {
  Dataset dataset = ramp(200);
  dataset.segment.tail(80).setOnes();
  const auto clusters = make_clusters(dataset);
  EXPECT_EQ(clusters->segment, (Eigen::Vector2i{0, 0}));
  EXPECT_EQ(clusters->last_segment, (Eigen::Vector2i{0, 1})) << "the segment changes at 120 s";
}

TEST(Clusters, NumberThePowerOnBeforeEach) {
  Dataset dataset = ramp(900);
  // On, off, on, on, off, off, on: three power-ons.
  const std::vector<bool> is_off{false, true, false, false, true, true, false};
  for (const bool off : is_off) {
    dataset.segments.push_back({"hold", true, {}, {}, -1});
    dataset.segments.back().unit.off = off;
  }
  const std::vector<int> segment{0, 0, 1, 2, 3, 4, 5, 6, 6};  // one segment for each cluster
  for (Eigen::Index i = 0; i < 900; ++i) {
    dataset.segment(i) = segment[static_cast<std::size_t>(i / 100)];
    if (is_off[static_cast<std::size_t>(dataset.segment(i))]) dataset.bias_deg_per_h(i) = std::nan("");
  }
  const auto clusters = make_clusters(dataset);
  ASSERT_TRUE(clusters);
  EXPECT_EQ(clusters->power_on, (Eigen::VectorXi(6) << 0, 0, 1, 1, 2, 2).finished());
  EXPECT_EQ(count_power_ons(*clusters), 3);
  const Clusters last = pick_clusters(*clusters, {4, 5});
  EXPECT_EQ(count_power_ons(last), 1);
  const auto joined = concatenate({*clusters, last, *clusters});
  EXPECT_EQ(joined->power_on.tail(8), (Eigen::VectorXi(8) << 5, 5, 6, 6, 7, 7, 8, 8).finished());
  EXPECT_EQ(count_power_ons(*joined), 7);
}

TEST(Clusters, HaveOnePowerOnWithoutSegments) {
  const auto clusters = make_clusters(ramp(400));
  EXPECT_EQ(count_power_ons(*clusters), 1);
  EXPECT_EQ(count_power_ons(*concatenate({*clusters, *clusters})), 2) << "each run is a power-on of its own";
  EXPECT_EQ(count_power_ons({}), 0);
}

TEST(Clusters, PickAndConcatenateRows) {
  const auto clusters = make_clusters(ramp(400));
  const Clusters picked = pick_clusters(*clusters, {3, 1});
  EXPECT_EQ(picked.start_s, (Eigen::Vector2d{300, 100}));
  const auto joined = concatenate({*clusters, picked});
  ASSERT_TRUE(joined);
  EXPECT_EQ(joined->start_s.size(), 6);
  EXPECT_EQ(joined->bias_deg_per_h(5), clusters->bias_deg_per_h(1));
  EXPECT_FALSE(concatenate({}));
}

TEST(Clusters, FollowTimeStampsOfRealRecord) {
  const auto dataset = load_freeimu(FreeImuAxis::x);
  if (!dataset) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
  const auto clusters = make_clusters(*dataset);
  ASSERT_EQ(clusters->start_s.size(), 21);
  EXPECT_EQ(clusters->dropped_rest, 2378);
  EXPECT_NEAR(clusters->temperature_c(0, 0), 14.92684, 5e-6);
  EXPECT_NEAR(clusters->temperature_c(20, 0), 28.85071, 5e-6);
  EXPECT_NEAR(clusters->temperature_c(0, 1), 13.79005, 5e-6);
  EXPECT_NEAR(clusters->temperature_c(20, 1), 27.90662, 5e-6);
  EXPECT_EQ(clusters->samples.minCoeff(), 2371);
  EXPECT_EQ(clusters->samples.maxCoeff(), 3312);
  EXPECT_EQ(make_clusters(*dataset, 10)->start_s.size(), 215);
}

}  // namespace
}  // namespace gyrotherm::data
