// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/control_chart.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.hpp"

namespace gyrotherm::assurance {
namespace {

std::vector<ChartInput> normal_runs(std::uint64_t seed, int runs, double shift_after = 1e9, double shift = 0) {
  RandomStream random(seed, RandomPurpose::drift);
  std::vector<ChartInput> inputs;
  for (int r = 0; r < runs; ++r)
    inputs.push_back({.value = 5 + 0.1 * random.normal() + (r >= shift_after ? shift : 0)});
  return inputs;
}

TEST(ControlChart, HasTheStatedFalseAlarmRateFromTheFifthRunOn) {
  // A rate of 10 % with limits estimated from 4 to 11 runs. Limits of known parameters would signal far more often.
  const ChartLimits limits = limits_for(0.1, 1);
  int judged = 0, individual = 0, any = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed)
    for (const ChartPoint& point : judge(normal_runs(seed, 5), limits)) {
      judged += point.is_judged ? 1 : 0;
      individual += point.individual_is_out ? 1 : 0;
      any += point.is_out() ? 1 : 0;
    }
  EXPECT_EQ(judged, 4000) << "the fifth run is the first";
  EXPECT_NEAR(individual / 4000.0, 0.05, 0.011) << "half of the rate belongs to the individuals";
  EXPECT_LE(any / 4000.0, 0.1);
}

TEST(ControlChart, QIsStandardNormalAndUncorrelatedForFewRuns) {
  const ChartLimits never{.individuals = 8, .ewma = 8};
  double sum = 0, squares = 0, products = 0;
  int count = 0, pairs = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const auto points = judge(normal_runs(seed, 12), never);
    for (std::size_t r = 4; r < points.size(); ++r) {
      sum += points[r].q;
      squares += points[r].q * points[r].q;
      ++count;
      if (r == 4) continue;
      products += points[r].q * points[r - 1].q;
      ++pairs;
    }
  }
  EXPECT_NEAR(sum / count, 0, 0.04);
  EXPECT_NEAR(squares / count, 1, 0.06);
  EXPECT_NEAR(products / pairs, 0, 0.04);
}

TEST(ControlChart, DetectsShiftAndDoesNotLearnFromIt) {
  const auto points = judge(normal_runs(3, 30, 20, 1), limits_for(0.01, 10));
  EXPECT_FALSE(points[19].is_out());
  for (std::size_t r = 20; r < 30; ++r) EXPECT_TRUE(points[r].is_out()) << r;
  EXPECT_DOUBLE_EQ(points[29].centre, points[20].centre) << "runs out of control do not move the mean";
}

TEST(ControlChart, StartsNewLevelWithItsOwnMean) {
  auto inputs = normal_runs(3, 30, 20, 1);
  inputs[20].is_excluded = true;
  inputs[21].starts_level = true;
  const auto points = judge(inputs, limits_for(0.01, 10));
  EXPECT_TRUE(points[20].is_out());
  EXPECT_FALSE(points[21].is_judged) << "no run of the level to compare with";
  for (std::size_t r = 22; r < 30; ++r) {
    EXPECT_TRUE(points[r].is_judged);
    EXPECT_FALSE(points[r].is_out()) << r;
  }
  EXPECT_NEAR(points[29].centre, 6, 0.2);
}

TEST(ControlChart, SkipsMissingValuesAndConstantOnes) {
  auto inputs = normal_runs(1, 12);
  inputs[6].value = std::numeric_limits<double>::quiet_NaN();
  const auto points = judge(inputs, limits_for(0.01, 1));
  EXPECT_FALSE(points[6].is_judged);
  EXPECT_FALSE(points[6].is_out());
  EXPECT_TRUE(points[7].is_judged);
  const std::vector<ChartInput> constant(10, {.value = 2});
  const auto flat = judge(constant, limits_for(0.01, 1));
  EXPECT_EQ(flat.size(), 10u);
  for (const ChartPoint& point : flat) EXPECT_FALSE(point.is_judged) << "no deviation to compare with";
}

TEST(ControlChart, LimitsOfScatterArePositiveOnItsOwnScale) {
  RandomStream random(9, RandomPurpose::drift);
  std::vector<ChartInput> inputs;
  for (int r = 0; r < 20; ++r) inputs.push_back({.value = 0.002 + 0.0002 * random.normal()});
  const auto points = judge(inputs, limits_for(0.01, 10), ChartScale::cube_root_of_variance);
  EXPECT_NEAR(points[19].value, inputs[19].value, 1e-12);
  EXPECT_GT(points[19].low, 0);
  EXPECT_GT(points[19].high - points[19].centre, points[19].centre - points[19].low) << "skewed like a variance";
}

}  // namespace
}  // namespace gyrotherm::assurance
