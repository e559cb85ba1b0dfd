// SPDX-License-Identifier: Apache-2.0
#include "apps/console/time_left.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace gyrotherm::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(TimeLeft, AssumesTheAverageRateSoFar) {
  TimeLeft left;
  EXPECT_EQ(left.after(0.25, seconds(10)), Duration(seconds(30)));
  EXPECT_EQ(left.after(0.5, seconds(20)), Duration(seconds(20)));
}

TEST(TimeLeft, CountsDownWhileTheFractionStands) {
  TimeLeft left;
  auto before = left.after(0.2, seconds(4));
  ASSERT_EQ(before, Duration(seconds(16)));
  for (int second = 5; second < 20; ++second) {
    const auto now = left.after(0.2, seconds(second));
    EXPECT_EQ(now, *before - seconds(1)) << second;
    before = now;
  }
  EXPECT_FALSE(left.after(0.2, seconds(20)));
  EXPECT_FALSE(left.after(0.2, seconds(200)));
  EXPECT_EQ(left.after(0.5, seconds(202)), Duration(seconds(202))) << "the fraction has changed";
}

TEST(TimeLeft, IsUnknownAtTheBeginAndAtTheEnd) {
  TimeLeft left;
  EXPECT_FALSE(left.after(0, seconds(5)));
  EXPECT_FALSE(left.after(0.009, seconds(6)));
  EXPECT_FALSE(left.after(1, seconds(7)));
  TimeLeft early;
  EXPECT_FALSE(early.after(0.5, milliseconds(1999)));
  EXPECT_TRUE(early.after(0.5, milliseconds(2000)));
}

}  // namespace
}  // namespace gyrotherm::app
