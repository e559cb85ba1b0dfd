// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/placement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

data::Clusters clusters_of(const data::SyntheticRun& run) { return *make_clusters(make_synthetic_run(run)); }

/// Sets a bias that depends on a single thermometer.
void set_bias_of_thermometer(data::Clusters& clusters, Eigen::Index thermometer, std::uint64_t seed) {
  // A random stream that is independent of the temperatures.
  std::mt19937_64 random(1000 + seed);
  std::normal_distribution<double> noise(0, 1e-3);
  const Eigen::VectorXd t = clusters.temperature_c.col(thermometer).array() / 20;
  clusters.bias_deg_per_h = 0.02 * t + 0.01 * t.cwiseAbs2();
  for (double& bias : clusters.bias_deg_per_h) bias += noise(random);
}

/// Returns the clusters with only these thermometers. A thermometer may be listed twice.
data::Clusters reduced(const data::Clusters& from, const std::vector<Eigen::Index>& columns) {
  data::Clusters clusters = from;
  clusters.thermometers.clear();
  for (const Eigen::Index column : columns) clusters.thermometers.push_back(from.thermometers[column]);
  clusters.temperature_c = from.temperature_c(Eigen::all, columns);
  clusters.rate_c_per_min = from.rate_c_per_min(Eigen::all, columns);
  return clusters;
}

TEST(Placement, EliminatesOnlyRelevantThermometerLast) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    data::Clusters clusters = wandering(clusters_of({.hold_s = 1000}), seed);
    const Eigen::Index driver = seed % 8;
    set_bias_of_thermometer(clusters, driver, seed);
    const auto placement = study_placement({clusters}, {});
    ASSERT_TRUE(placement) << text(placement.error());
    ASSERT_EQ(placement->elimination.size(), 7u);
    EXPECT_EQ(placement->elimination.back().kept, std::vector<std::string>{clusters.thermometers[driver]});
    EXPECT_EQ(placement->alone.back().left_out, std::vector<std::string>{clusters.thermometers[driver]});
    EXPECT_GT(placement->alone.back().price_deg_per_h, 3 * placement->alone.back().price_error_deg_per_h);
  }
}

TEST(Placement, FindsNoPriceForDuplicateThermometer) {
  data::Clusters clusters = reduced(clusters_of({}), {0, 3, 3, 6});
  clusters.thermometers[2] = "twin";
  const auto placement = study_placement({clusters}, {});
  ASSERT_TRUE(placement) << text(placement.error());
  for (const SubsetAccuracy& one : placement->alone) {
    if (one.left_out.front() != "D" && one.left_out.front() != "twin") continue;
    EXPECT_LT(std::abs(one.price_deg_per_h), 0.02 * placement->all.held_out.std);
  }
  const std::string first = placement->elimination.front().left_out.front();
  EXPECT_TRUE(first == "D" || first == "twin") << first;
  EXPECT_GE(placement->spared, 1);
}

TEST(Placement, OrdersStepsConsistently) {
  const auto placement = study_placement({clusters_of({.hold_s = 800})}, {clusters_of({.hold_s = 700, .seed = 2})});
  ASSERT_TRUE(placement);
  EXPECT_EQ(placement->folds, "leave one cycle out (4)");
  EXPECT_EQ(placement->alone.size(), 8u);
  EXPECT_TRUE(std::ranges::is_sorted(placement->alone, {}, &SubsetAccuracy::price_deg_per_h));
  EXPECT_EQ(placement->elimination.front().left_out, placement->alone.front().left_out);
  for (std::size_t k = 0; k < placement->elimination.size(); ++k) {
    const SubsetAccuracy& step = placement->elimination[k];
    EXPECT_EQ(step.left_out.size(), k + 1);
    EXPECT_EQ(step.left_out.size() + step.kept.size(), 8u);
    EXPECT_DOUBLE_EQ(step.price_deg_per_h, step.held_out.std - placement->all.held_out.std);
    EXPECT_TRUE(step.unseen);
  }
  EXPECT_LE(placement->best_pair->held_out.std, placement->elimination[1].held_out.std);
  EXPECT_LE(placement->best_three->held_out.std, placement->elimination[2].held_out.std);
  EXPECT_EQ(placement->all.price_deg_per_h, 0);
}

/// Adds two values measured by the gyro: its temperature, which is sometimes missing, and a count.
data::Clusters with_own_values(const data::Clusters& from) {
  data::Clusters clusters = reduced(from, {0, 3, 6, 6, 6});
  clusters.thermometers[3] = "self";
  clusters.thermometers[4] = "aux:frames";
  clusters.temperature_c.col(4).setConstant(1000);
  for (Eigen::Index k = 7; k < clusters.temperature_c.rows(); k += 50)
    clusters.temperature_c.row(k).tail(2).setConstant(std::nan(""));
  return clusters;
}

TEST(Placement, ExcludesValuesMeasuredByGyro) {
  const data::Clusters all = clusters_of({.hold_s = 800}), others = clusters_of({.hold_s = 700, .seed = 2});
  const auto placement = study_placement({with_own_values(all)}, {reduced(others, {0, 3, 6})});
  ASSERT_TRUE(placement) << text(placement.error());
  const auto without = study_placement({reduced(all, {0, 3, 6})}, {});
  EXPECT_EQ(placement->all.kept, without->all.kept);
  EXPECT_EQ(placement->all.held_out.std, without->all.held_out.std);
  EXPECT_EQ(placement->elimination.back().left_out, without->elimination.back().left_out);
  EXPECT_TRUE(placement->all.unseen) << "the unseen record needs no values measured by the gyro";
  const auto one = study_placement({reduced(with_own_values(all), {0, 3, 4})}, {});
  ASSERT_FALSE(one);
  EXPECT_EQ(one.error().what, "needs at least two thermometers, the record has 1");
}

TEST(Placement, FailsForNonFiniteResidual) {
  data::Clusters clusters = clusters_of({.hold_s = 800});
  clusters.temperature_c(5, 2) = std::nan("");
  const auto placement = study_placement({clusters}, {});
  ASSERT_FALSE(placement);
  EXPECT_EQ(placement.error().kind, FaultKind::usage);
}

TEST(Placement, RefusesSingleThermometerAndStopsOnRequest) {
  const data::Clusters clusters = clusters_of({.hold_s = 800});
  EXPECT_EQ(study_placement({reduced(clusters, {0})}, {}).error().kind, FaultKind::usage);
  EXPECT_EQ(study_placement({}, {}).error().kind, FaultKind::usage);
  EXPECT_EQ(study_placement({clusters}, {reduced(clusters, {0, 1})}).error().kind, FaultKind::usage);
  const auto stopped = study_placement({clusters}, {}, {}, [](std::string_view, double) { return false; });
  EXPECT_EQ(stopped.error().kind, FaultKind::interrupted);
  const auto two = study_placement({reduced(clusters, {0, 4})}, {});
  ASSERT_TRUE(two);
  EXPECT_EQ(two->elimination.size(), 1u);
  EXPECT_FALSE(two->best_pair);
}

}  // namespace
}  // namespace gyrotherm::model
