// SPDX-License-Identifier: Apache-2.0
/// The pace of virtual runs.
#include "apps/gyrotherm/run/pace.hpp"

#include <gtest/gtest.h>

#include <array>

namespace gyrotherm::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
constexpr Pacer::TimePoint kStart{std::chrono::hours(1)};

TEST(Pace, IsRealMaximumOrMultiple) {
  EXPECT_EQ(parse_pace("real").value(), 1);
  EXPECT_EQ(parse_pace("max").value(), 0);
  EXPECT_EQ(parse_pace("x60").value(), 60);
  EXPECT_EQ(parse_pace("x0.5").value(), 0.5);
  for (const auto* text : {"", "60", "x", "x0", "x-1", "xnan", "xinf", "x1e7", "X60", "x60 ", "fast"}) {
    const auto pace = parse_pace(text);
    ASSERT_FALSE(pace) << text;
    EXPECT_EQ(pace.error().kind, FaultKind::usage) << text;
  }
}

TEST(Pace, MakesSecondsEquallyLong) {
  Pacer pacer(10);
  auto now = kStart;
  for (int k = 1; k <= 100; ++k) {
    const auto due = pacer.next_second(now, false);
    ASSERT_TRUE(due);
    EXPECT_EQ(*due, kStart + k * milliseconds(100));
    now = *due + milliseconds(k % 7);  // the wait ends a little late
  }
}

TEST(Pace, DoesNotWaitAtMaximum) {
  Pacer pacer(0);
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(pacer.next_second(kStart, false));
}

TEST(Pace, PausedRunTakesRealTime) {
  for (const double pace : std::array{0.0, 2.0, 1000.0}) {
    Pacer pacer(pace);
    static_cast<void>(pacer.next_second(kStart, false));
    const auto later = kStart + seconds(10);
    EXPECT_EQ(pacer.next_second(later, true), later + seconds(1)) << pace;
    EXPECT_EQ(pacer.next_second(later + seconds(1), true), later + seconds(2)) << pace;
  }
  Pacer slow(0.5);
  EXPECT_EQ(slow.next_second(kStart, true), kStart + seconds(2));
}

TEST(Pace, SlowMachineDoesNotCatchUp) {
  Pacer pacer(1);
  EXPECT_EQ(pacer.next_second(kStart, false), kStart + seconds(1));
  EXPECT_EQ(pacer.next_second(kStart + milliseconds(1400), false), kStart + seconds(2)) << "a little late";
  const auto late = kStart + seconds(60);
  EXPECT_EQ(pacer.next_second(late, false), late + seconds(1));
}

TEST(Pace, TickThatTakesLongerThanItsSecondIsFollowedImmediately) {
  Pacer pacer(1000);
  EXPECT_TRUE(pacer.next_second(kStart, false));
  EXPECT_FALSE(pacer.next_second(kStart + milliseconds(5), false));
}

}  // namespace
}  // namespace gyrotherm::app
