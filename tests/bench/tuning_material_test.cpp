// SPDX-License-Identifier: Apache-2.0
#include "bench/svr/tuning_material.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace gyrotherm::bench {
namespace {

TEST(Trace, EachStoredOneIsAWholeJobInsideTheBox) {
  for (const char* name : {"gyro600", "gyro2216"}) {
    const auto trace = load_trace(std::string(GYROTHERM_SOURCE_DIR) + "/bench/svr/" + name + ".trace");
    ASSERT_TRUE(trace) << text(trace.error());
    EXPECT_EQ(trace->size(), 620u) << name;
    for (const TracePosition& p : *trace) {
      EXPECT_TRUE(-2 <= p.log2_c && p.log2_c <= 12) << name << ": " << trace_line(p);
      EXPECT_TRUE(-8 <= p.log2_gamma && p.log2_gamma <= 3) << name << ": " << trace_line(p);
      EXPECT_TRUE(-8 <= p.log2_epsilon && p.log2_epsilon <= -1) << name << ": " << trace_line(p);
      EXPECT_TRUE(p.error > 0 && p.error < 2) << name << ": " << trace_line(p);
    }
  }
}

TEST(Trace, PositionsAreSpreadAtEqualStride) {
  std::vector<TracePosition> trace(620);
  for (std::size_t i = 0; i < trace.size(); ++i) trace[i].log2_c = static_cast<double>(i);
  const auto some = evenly_spaced(trace, 20);
  ASSERT_EQ(some.size(), 20u);
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i].log2_c, 15 + 31 * static_cast<double>(i));
  EXPECT_EQ(evenly_spaced(trace, 620).size(), 620u);
  EXPECT_EQ(evenly_spaced(trace, 1000).size(), 620u);
}

TEST(Trace, KeepsLineThroughWriteAndRead) {
  const TracePosition p{.log2_c = 7.25, .log2_gamma = -5.5, .log2_epsilon = -8, .error = 0.00069, .seconds = 0.5};
  EXPECT_EQ(trace_line(p), "7.250000 -5.500000 -8.000000 0.00069 0.5000\n");
  EXPECT_DOUBLE_EQ(p.parameters().C, std::exp2(7.25));
}

TEST(ShuffledFolds, HoldEachRowOutOnceAndTrainOnTheRest) {
  SampleSet set{.name = "numbers", .x = svm::SampleMatrix(53, 1), .y = Eigen::VectorXd::LinSpaced(53, 0, 52)};
  set.x.col(0) = set.y;
  std::multiset<double> held_out;
  for (const svm::TuningFold& fold : shuffled_folds(set)) {
    EXPECT_EQ(fold.train_y.size() + fold.test_y.size(), 53);
    EXPECT_EQ(Eigen::VectorXd(fold.train_x.col(0)), fold.train_y);
    std::set<double> all(fold.train_y.begin(), fold.train_y.end());
    all.insert(fold.test_y.begin(), fold.test_y.end());
    EXPECT_EQ(all.size(), 53u);
    held_out.insert(fold.test_y.begin(), fold.test_y.end());
  }
  EXPECT_EQ(held_out.size(), 53u);
  EXPECT_EQ(std::set<double>(held_out.begin(), held_out.end()).size(), 53u);
}

}  // namespace
}  // namespace gyrotherm::bench
