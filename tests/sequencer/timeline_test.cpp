#include "sequencer/timeline.hpp"

#include <gtest/gtest.h>

#include "tests/sequencer/profiles.hpp"

namespace gyrotherm {
namespace {

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

TEST(Timeline, SegmentsFollowEachOther) {
  const auto timeline = plan(parsed(kProgram));
  ASSERT_EQ(timeline.segments.size(), 7u);
  EXPECT_EQ(timeline.segments[0].from, Celsius{20});
  EXPECT_EQ(timeline.segments[1].from, Celsius{20});
  EXPECT_EQ(timeline.segments[1].to, Celsius{-40});
  EXPECT_EQ(timeline.segments[2].from, Celsius{-40});
  for (std::size_t i = 1; i < 7; ++i)
    EXPECT_EQ(timeline.segments[i].start, timeline.segments[i - 1].start + timeline.segments[i - 1].duration);
}

TEST(Timeline, CyclesCountRampsHoldsAndWholeClusters) {
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

TEST(Timeline, IsDescribedAsATable) {
  const auto profile = parsed(kProgram);
  EXPECT_EQ("\n" + describe(profile, plan(profile)), R"(
p: p

)");
}

}  // namespace
}  // namespace gyrotherm
