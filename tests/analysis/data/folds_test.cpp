// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/folds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

/// Returns clusters of 100 s at the given positions, in the given cycles.
Clusters clusters_at(const std::vector<int>& positions, const std::vector<int>& cycles) {
  Clusters clusters;
  const auto rows = static_cast<Eigen::Index>(positions.size());
  clusters.thermometers = {"A"};
  clusters.start_s.resize(rows);
  clusters.cycle.resize(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    clusters.start_s(k) = 100.0 * positions[k];
    clusters.cycle(k) = cycles[k];
  }
  clusters.temperature_c.setZero(rows, 1);
  clusters.rate_c_per_min.setZero(rows, 1);
  clusters.bias_deg_per_h.setZero(rows);
  clusters.set_point_c.setZero(rows);
  clusters.segment.setZero(rows);
  clusters.last_segment.setZero(rows);
  clusters.samples.setConstant(rows, 100);
  return clusters;
}

Clusters without_cycles(int rows) {
  std::vector<int> positions(rows);
  for (int k = 0; k < rows; ++k) positions[k] = k;
  return clusters_at(positions, std::vector<int>(rows, -1));
}

FoldOptions blocks(int count, double guard_minutes) {
  return {.kind = FoldKind::blocks, .blocks = count, .guard_minutes = guard_minutes};
}

void expect_each_held_out_once(const FoldPlan& plan, std::size_t rows) {
  std::vector<int> times(rows, 0);
  for (const Fold& fold : plan.folds) {
    for (const Eigen::Index k : fold.held_out) ++times[k];
    EXPECT_TRUE(std::ranges::is_sorted(fold.held_out));
    EXPECT_TRUE(std::ranges::is_sorted(fold.training));
  }
  EXPECT_EQ(std::ranges::count(times, 1), static_cast<std::ptrdiff_t>(rows));
}

TEST(Folds, HoldOutCyclesOfEachRecord) {
  const Clusters a = *make_clusters(make_synthetic_run({}));
  const auto rows = static_cast<std::size_t>(a.start_s.size());
  const auto plan = plan_folds({a, a});
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->folds.size(), 8u);
  EXPECT_EQ(plan->statement, "leave one cycle out (8)");
  expect_each_held_out_once(*plan, 2 * rows);
  for (const Fold& fold : plan->folds) {
    EXPECT_EQ(fold.held_out.size() + fold.training.size(), 2 * rows) << "there is no guard between cycles";
    for (const Eigen::Index k : fold.held_out) {
      EXPECT_EQ(a.cycle(k % rows), a.cycle(fold.held_out.front() % rows));
    }
  }
}

TEST(Folds, HoldOutFourGuardedBlocksWithoutCycles) {
  const auto plan = plan_folds({without_cycles(400)});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->statement, "4 consecutive blocks with a guard of 45 min");
  ASSERT_EQ(plan->folds.size(), 4u);
  EXPECT_EQ(plan->folds[1].held_out.front(), 100);
  EXPECT_EQ(plan->folds[1].held_out.back(), 199);
  EXPECT_EQ(plan->folds[1].training.size(), 400u - 100 - 2 * 27) << "the guard of 45 min is 27 clusters on each side";
  EXPECT_FALSE(plan_folds({without_cycles(7)}));
}

TEST(Folds, LimitDefaultGuardToHalfBlock) {
  const auto plan = plan_folds({without_cycles(21)});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->statement, "4 consecutive blocks with a guard of 3.33 min");
  const auto both = plan_folds({without_cycles(21), without_cycles(400)});
  EXPECT_EQ(both->statement, "8 consecutive blocks with a guard of 3.33 to 45 min");
}

TEST(Folds, AssignClustersOutsideCyclesToPreviousCycle) {
  const auto plan = plan_folds({clusters_at({0, 1, 2, 3, 4, 5}, {-1, 0, -1, 1, 1, -1})});
  ASSERT_EQ(plan->folds.size(), 2u);
  EXPECT_EQ(plan->folds[0].held_out, (std::vector<Eigen::Index>{0, 1, 2}));
  EXPECT_EQ(plan->folds[1].held_out, (std::vector<Eigen::Index>{3, 4, 5}));
}

TEST(Folds, CutSingleCycleIntoBlocks) {
  const Clusters one = clusters_at({0, 1, 2, 3, 4, 5, 6, 7}, std::vector<int>(8, 0));
  EXPECT_EQ(plan_folds({one})->folds.size(), 4u);
  EXPECT_EQ(plan_folds({one, one})->statement, "leave one cycle out (2)");
  EXPECT_EQ(plan_folds({one, without_cycles(400)})->statement,
            "leave one cycle out (1) and 4 consecutive blocks with a guard of 45 min");
}

TEST(Folds, TrainOnlyOutsideGuard) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto draw = [&](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
    const int parts = draw(2, 6), clusters = 30 + draw(0, 60);
    std::vector<int> positions, cycles;
    for (int k = 0, at = draw(0, 5), cycle = -1; k < clusters; ++k) {
      at += draw(0, 9) == 0 ? draw(2, 8) : 1;
      if (draw(0, 14) == 0) ++cycle;
      positions.push_back(at);
      cycles.push_back(cycle);
    }
    const Clusters record = clusters_at(positions, cycles);
    FoldOptions options = blocks(parts, draw(0, 12));
    if (draw(0, 1) == 1) options.kind = FoldKind::cycles;
    const auto plan = plan_folds({record, record}, options);
    // Skips plans in which the guard leaves no training clusters.
    if (!plan) continue;
    expect_each_held_out_once(*plan, 2 * record.start_s.size());
    const auto record_start = [&](Eigen::Index k) { return k < clusters ? 0 : clusters; };
    for (const Fold& fold : plan->folds) {
      for (Eigen::Index k = 0; k < 2 * clusters; ++k) {
        if (std::ranges::binary_search(fold.held_out, k)) {
          EXPECT_FALSE(std::ranges::binary_search(fold.training, k));
          continue;
        }
        double gap_s = 1e9;
        for (const Eigen::Index h : fold.held_out) {
          if (record_start(h) != record_start(k)) continue;
          gap_s = std::min(gap_s, std::abs(record.start_s(h % clusters) - record.start_s(k % clusters)) - 100);
        }
        EXPECT_EQ(std::ranges::binary_search(fold.training, k), gap_s >= 60 * *options.guard_minutes) << k;
      }
    }
  }
}

TEST(Folds, FailWhenGuardLeavesNoTrainingClusters) {
  const auto plan = plan_folds({without_cycles(40)}, blocks(4, 1000));
  ASSERT_FALSE(plan);
  EXPECT_NE(plan.error().what.find("shorter guard"), std::string::npos) << plan.error().what;
}

TEST(Folds, FailWhenBlocksOutnumberClusters) {
  for (const int count : {41, 1 << 30, std::numeric_limits<int>::max()}) {
    const auto plan = plan_folds({without_cycles(40)}, blocks(count, 0));
    ASSERT_FALSE(plan);
    EXPECT_NE(plan.error().what.find("is too short for"), std::string::npos) << plan.error().what;
  }
}

TEST(Folds, KeepGuardOfOuterFoldInInnerFolds) {
  const Clusters record = without_cycles(400);
  const TrainingSet training_set{record, *plan_folds({record}, blocks(5, 20))};
  EXPECT_EQ(training_set.folds.folds.size(), 5u);
  for (const Fold& outer : training_set.folds.folds) {
    const TrainingSet inner = restrict_rows(training_set, outer.training);
    EXPECT_EQ(inner.folds.folds.size(), 4u);
    expect_each_held_out_once(inner.folds, outer.training.size());
    for (const Fold& fold : inner.folds.folds) {
      for (const Eigen::Index k : fold.training) {
        for (const Eigen::Index h : outer.held_out) {
          EXPECT_GE(std::abs(inner.clusters.start_s(k) - record.start_s(h)), 1200 + 100);
        }
        for (const Eigen::Index h : fold.held_out) {
          EXPECT_GE(std::abs(inner.clusters.start_s(k) - inner.clusters.start_s(h)), 1200 + 100);
        }
      }
    }
  }
}

TEST(Folds, BecomeBlocksWhenOneFoldRemains) {
  const Clusters record = clusters_at({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, {0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1});
  const TrainingSet training_set{record, *plan_folds({record})};
  const auto left = ensure_two_folds(restrict_rows(training_set, training_set.folds.folds[0].training));
  ASSERT_TRUE(left);
  EXPECT_EQ(left->folds.folds.size(), 4u);
  EXPECT_FALSE(ensure_two_folds(restrict_rows(training_set, training_set.folds.folds[1].training)))
      << "four clusters are too few for two folds";
}

TEST(Folds, HoldOutRecordsForThreeRecordsWithoutCycles) {
  const std::vector<Clusters> records = {without_cycles(5), without_cycles(1), without_cycles(3)};
  const auto plan = plan_folds(records);
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->folds.size(), 3u);
  expect_each_held_out_once(*plan, 9);
  EXPECT_EQ(plan->folds[1].held_out, std::vector<Eigen::Index>{5});
  EXPECT_EQ(plan->folds[1].training, (std::vector<Eigen::Index>{0, 1, 2, 3, 4, 6, 7, 8}));
  EXPECT_EQ(plan->statement, "leave one record out (3)");
  EXPECT_EQ(plan_folds(records, {.kind = FoldKind::records, .guard_minutes = 45})->folds[1].training,
            plan->folds[1].training)
      << "guards do not extend into other records";
}

TEST(Folds, DoNotHoldOutRecordsWithCyclesOrFewRecords) {
  const Clusters blocks = without_cycles(12), cycles = clusters_at({0, 1, 2, 3}, {0, 0, 1, 1});
  for (const FoldKind kind : {FoldKind::automatic, FoldKind::cycles}) {
    EXPECT_EQ(plan_folds({blocks, blocks}, {.kind = kind})->folds.size(), 8u);
    EXPECT_EQ(plan_folds({blocks, blocks, cycles}, {.kind = kind})->folds.size(), 10u);
  }
  EXPECT_EQ(plan_folds({blocks, blocks, blocks}, {.kind = FoldKind::cycles})->folds.size(), 12u);
  EXPECT_EQ(plan_folds({cycles, cycles}, {.kind = FoldKind::records})->folds.size(), 2u);
}

TEST(Folds, HoldOutEachPowerOnIfRequested) {
  Clusters record = without_cycles(40);
  record.power_on.setZero(40);
  record.power_on.segment(10, 18).setConstant(3);  // numbers may have gaps
  record.power_on.tail(12).setConstant(7);
  const auto plan = plan_folds({record}, *parse_folds("starts"));
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->statement, "leave one power-on out (3)");
  ASSERT_EQ(plan->folds.size(), 3u);
  EXPECT_EQ(plan->folds[1].held_out.front(), 10);
  EXPECT_EQ(plan->folds[1].held_out.size(), 18u);
  EXPECT_EQ(plan->folds[1].training.size(), 22u);
  expect_each_held_out_once(*plan, 40);
  EXPECT_EQ(plan_folds({without_cycles(40)}, *parse_folds("starts"))->folds.size(), 4u) << "a single power-on";
}

TEST(Folds, AreShortBlocksForSeveralPowerOns) {
  Clusters record = without_cycles(540);  // 15 h
  record.power_on.setZero(540);
  record.power_on.tail(20).setOnes();
  const auto plan = plan_folds({record});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->statement, "20 consecutive blocks with a guard of 21.7 min");
  for (const Fold& fold : plan->folds) EXPECT_GT(count_power_ons(pick_clusters(record, fold.training)), 0);
  expect_each_held_out_once(*plan, 540);
  EXPECT_EQ(plan_folds({record}, *parse_folds("blocks"))->folds.size(), 4u) << "as requested";
  record.power_on.setZero();
  EXPECT_EQ(plan_folds({record})->folds.size(), 4u) << "a single power-on";
}

TEST(Folds, PreferCyclesToPowerOns) {
  Clusters record = clusters_at({0, 1, 2, 3, 4, 5, 6, 7}, {0, 0, 0, 0, 1, 1, 1, 1});
  record.power_on = (Eigen::VectorXi(8) << 0, 0, 1, 1, 2, 2, 3, 3).finished();
  EXPECT_EQ(plan_folds({record})->statement, "leave one cycle out (2)");
}

TEST(Folds, FailForSingleRecordHeldOut) {
  const auto plan = plan_folds({without_cycles(12)}, {.kind = FoldKind::records});
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().kind, FaultKind::usage);
  EXPECT_NE(plan.error().what.find("a single record"), std::string::npos) << plan.error().what;
}

TEST(Folds, HoldOutEachRemainingRecord) {
  const std::vector<Clusters> records = {without_cycles(4), without_cycles(3), without_cycles(2)};
  const TrainingSet training_set{*concatenate(records), *plan_folds(records)};
  const TrainingSet left = restrict_rows(training_set, training_set.folds.folds[1].training);
  ASSERT_EQ(left.folds.folds.size(), 2u);
  EXPECT_EQ(left.folds.folds[0].held_out, (std::vector<Eigen::Index>{0, 1, 2, 3}));
  EXPECT_EQ(left.folds.folds[0].training, (std::vector<Eigen::Index>{4, 5}));
}

TEST(Folds, ParseKeywords) {
  EXPECT_EQ(parse_folds("auto")->kind, FoldKind::automatic);
  EXPECT_EQ(parse_folds("records")->kind, FoldKind::records);
  EXPECT_EQ(parse_folds("cycles")->kind, FoldKind::cycles);
  EXPECT_EQ(parse_folds("blocks")->blocks, kDefaultBlocks);
  EXPECT_EQ(parse_folds("blocks:6")->blocks, 6);
  for (const char* input : {"", "random", "blocks:", "blocks:1", "blocks:-3", "blocks:4x", "cycles:4", "records:2"}) {
    EXPECT_FALSE(parse_folds(input)) << input;
  }
}

TEST(FoldsByProgram, HoldOutAllRecordsOfProgramTogether) {
  const Clusters a = without_cycles(30), b = without_cycles(20), c = without_cycles(10);
  FoldOptions options = *parse_folds("programs");
  options.programs = {"rate", "random", "rate"};
  const auto plan = plan_folds({a, b, c}, options);
  ASSERT_TRUE(plan) << text(plan.error());
  EXPECT_EQ(plan->statement, "leave one program out (2)");
  ASSERT_EQ(plan->folds.size(), 2U);
  EXPECT_EQ(plan->folds[0].held_out.size(), 40U);
  EXPECT_EQ(plan->folds[0].training, plan->folds[1].held_out) << "only the record of the random program";
  EXPECT_EQ(plan->folds[1].training, plan->folds[0].held_out);
  EXPECT_EQ(plan->folds[0].training.front(), 30);
  EXPECT_EQ(plan->folds[0].training.back(), 49);
  expect_each_held_out_once(*plan, 60);
}

TEST(FoldsByProgram, RejectSingleProgram) {
  const Clusters a = without_cycles(30);
  FoldOptions options = *parse_folds("programs");
  options.programs = {"rate", "rate"};
  const auto plan = plan_folds({a, a}, options);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().kind, FaultKind::usage);
  EXPECT_NE(plan.error().what.find("\"rate\""), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::data
