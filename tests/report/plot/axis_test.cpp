// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "report/plot/plot.hpp"

namespace gyrotherm::plot {
namespace {

TEST(Axis, HasStepsOfOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(tick_step({0, 10}, 10), 1);
  EXPECT_DOUBLE_EQ(tick_step({0, 61.6}, 8), 10);
  EXPECT_DOUBLE_EQ(tick_step({-40, 60}, 6), 20);
  EXPECT_DOUBLE_EQ(tick_step({0, 0.03}, 6), 0.005);
}

TEST(Axis, LabelsTicksWithDecimalsOfStep) {
  const auto all = ticks({-0.01, 0.01}, 4);
  ASSERT_EQ(all.size(), 5U);
  EXPECT_EQ(all.front().label, "−0.010");
  EXPECT_EQ(all[2].label, "0.000");
  EXPECT_EQ(all.back().label, "0.010");
}

TEST(Axis, RoundsOutToExistingTicks) {
  for (int k = 1; k < 400; ++k) {
    const double high = 0.001 * k * k;
    for (const int count : {3, 4, 5, 8}) {
      const Range range = round_out({-0.37 * high, high}, count);
      const auto all = ticks(range, count);
      ASSERT_GE(all.size(), 2U) << high;
      EXPECT_NEAR(all.front().value, range.low, 1e-9 * high) << high << ' ' << count;
      EXPECT_NEAR(all.back().value, range.high, 1e-9 * high) << high << ' ' << count;
      EXPECT_LE(range.low, -0.37 * high * (1 - 1e-5));
      EXPECT_GE(range.high, high * (1 - 1e-5));
    }
  }
}

TEST(Axis, IsZeroToOneWithoutData) {
  const Range range = value_range({std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(range.low, 0);
  EXPECT_EQ(range.high, 1);
}

TEST(Axis, HasWidthForSingleValue) {
  const Range range = round_out({5, 5}, 4);
  EXPECT_LT(range.low, range.high);
}

TEST(LogarithmicAxis, RoundsOutToOneTwoOrFive) {
  for (int k = -40; k < 40; ++k) {
    const Range data{std::pow(10.0, 0.17 * k), std::pow(10.0, 0.17 * k + 0.9)};
    const Range range = round_out_logarithmically(data);
    EXPECT_LE(range.low, data.low * (1 + 1e-5)) << k;
    EXPECT_GE(range.high, data.high * (1 - 1e-5)) << k;
    EXPECT_GT(range.low, data.low / 2.6) << k;
    EXPECT_LT(range.high, data.high * 2.6) << k;
  }
}

TEST(LogarithmicAxis, LabelsPowersOfTenAndFillsEachDecade) {
  const auto all = logarithmic_ticks({0.001, 1});
  ASSERT_EQ(all.size(), 28U);
  EXPECT_EQ(all[0].label, "0.001");
  EXPECT_EQ(all[1].label, "");
  EXPECT_EQ(all[9].label, "0.01");
  EXPECT_EQ(all.back().label, "1");
  const auto small = logarithmic_ticks({2e-5, 5e-4});
  EXPECT_EQ(small.front().label, "2 × 10⁻⁵");
  EXPECT_EQ(small.back().label, "5 × 10⁻⁴");
}

TEST(LogarithmicAxis, SpacesDecadesEvenly) {
  const Scale scale{{0.01, 100}, 400, 0, true};
  EXPECT_NEAR(scale(0.01), 400, 1e-9);
  EXPECT_NEAR(scale(0.1), 300, 1e-9);
  EXPECT_NEAR(scale(100), 0, 1e-9);
  EXPECT_EQ(scale(0), 400) << "values of 0 are drawn at the lower edge";
  EXPECT_EQ(scale(-3), 400);
  EXPECT_TRUE(std::isnan(scale(std::numeric_limits<double>::quiet_NaN())));
}

TEST(LogarithmicAxis, IsDecadeWithoutData) {
  const Range range = find_positive_range({-1, 0, std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(range.low, 1);
  EXPECT_EQ(range.high, 10);
  EXPECT_LT(round_out_logarithmically({5, 5}).low, round_out_logarithmically({5, 5}).high);
}

}  // namespace
}  // namespace gyrotherm::plot
