#include "report/axis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gyrotherm {
namespace {

TEST(Axis, StepsByOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(tick_step({0, 10}, 10), 1);
  EXPECT_DOUBLE_EQ(tick_step({0, 61.6}, 8), 10);
  EXPECT_DOUBLE_EQ(tick_step({-40, 60}, 6), 20);
  EXPECT_DOUBLE_EQ(tick_step({0, 0.03}, 6), 0.005);
}

TEST(Axis, LabelsHaveTheDecimalsOfTheStep) {
  const auto all = ticks({-0.01, 0.01}, 4);
  ASSERT_EQ(all.size(), 5U);
  EXPECT_EQ(all.front().label, "−0.010");
  EXPECT_EQ(all[2].label, "0.000");
  EXPECT_EQ(all.back().label, "0.010");
}

TEST(Axis, RoundsOutToTicksThatAreThereThen) {
  for (int k = 1; k < 400; ++k) {
    const double high = 0.001 * k * k;
    for (const int count : {3, 4, 5, 8}) {
      const Range range = rounded_out({-0.37 * high, high}, count);
      const auto all = ticks(range, count);
      ASSERT_GE(all.size(), 2U) << high;
      EXPECT_NEAR(all.front().value, range.low, 1e-9 * high) << high << ' ' << count;
      EXPECT_NEAR(all.back().value, range.high, 1e-9 * high) << high << ' ' << count;
      EXPECT_LE(range.low, -0.37 * high * (1 - 1e-5));
      EXPECT_GE(range.high, high * (1 - 1e-5));
    }
  }
}

TEST(Axis, OfNothingIsZeroToOne) {
  const Range range = range_of({std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(range.low, 0);
  EXPECT_EQ(range.high, 1);
}

TEST(Axis, OfOneValueHasWidth) {
  const Range range = rounded_out({5, 5}, 4);
  EXPECT_LT(range.low, range.high);
}

}  // namespace
}  // namespace gyrotherm
