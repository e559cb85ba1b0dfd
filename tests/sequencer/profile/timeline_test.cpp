// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "sequencer/profile/profile.hpp"
#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::profile {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

const std::string kProgram = kHold20 + R"([[segment]]
kind = "repeat"
rates = [1, 3]
cycle = true
  [[segment.segment]]
  kind = "ramp"
  to = -40
  [[segment.segment]]
  kind = "hold"
  time = "250 s"
  guaranteed_soak = true
  [[segment.segment]]
  kind = "ramp"
  to = 20
)";

TEST(Timeline, PlacesSegmentsOneAfterAnother) {
  const auto timeline = plan(parsed(kProgram));
  ASSERT_EQ(timeline.segments.size(), 7u);
  EXPECT_EQ(timeline.segments[0].from, Celsius{20});
  EXPECT_EQ(timeline.segments[1].from, Celsius{20});
  EXPECT_EQ(timeline.segments[1].to, Celsius{-40});
  EXPECT_EQ(timeline.segments[2].from, Celsius{-40});
  for (std::size_t i = 1; i < 7; ++i)
    EXPECT_EQ(timeline.segments[i].start, timeline.segments[i - 1].start + timeline.segments[i - 1].duration);
}

TEST(Timeline, CountsRampsHoldsAndCompleteClustersOfCycles) {
  const auto timeline = plan(parsed(kProgram));
  ASSERT_EQ(timeline.cycles.size(), 2u);
  EXPECT_EQ(timeline.cycles[0].ramps, hours(2));
  EXPECT_EQ(timeline.cycles[0].holds, seconds(250));
  EXPECT_EQ(timeline.cycles[0].clusters, 74);
  EXPECT_EQ(timeline.cycles[1].ramps, minutes(40));
  EXPECT_EQ(timeline.all.ramps, minutes(160));
  EXPECT_EQ(timeline.all.holds, seconds(600));
  EXPECT_EQ(timeline.all.clusters, 102);
}

TEST(Timeline, FormatsTable) {
  const auto profile = parsed(kProgram);
  EXPECT_EQ("\n" + describe(profile, plan(profile)), R"(
p: p

  #  segment           start     time  from °C  to °C  °C/min  cycle     guaranteed soak
  1  hold 20 °C      0:00:00  0:01:40       20     20
  2  ramp to -40 °C  0:01:40  1:00:00       20    -40       1  1 °C/min
  3  hold -40 °C     1:01:40  0:04:10      -40    -40          1 °C/min  0:04:10 within ±2 K, at most 2:12:30
  4  ramp to 20 °C   1:05:50  1:00:00      -40     20       1  1 °C/min
  5  ramp to -40 °C  2:05:50  0:20:00       20    -40       3  3 °C/min
  6  hold -40 °C     2:25:50  0:04:10      -40    -40          3 °C/min  0:04:10 within ±2 K, at most 2:12:30
  7  ramp to 20 °C   2:30:00  0:20:00      -40     20       3  3 °C/min

  cycle       ramps    holds    total  clusters
  1 °C/min  2:00:00  0:04:10  2:04:10        74
  3 °C/min  0:40:00  0:04:10  0:44:10        26
  all       2:40:00  0:10:00  2:50:00       102
)");
}

}  // namespace
}  // namespace gyrotherm::profile
