// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::profile {
namespace {

constexpr ChamberLimits kChamber{Celsius{-45}, Celsius{70}, CelsiusPerMinute{6}, CelsiusPerMinute{4}};

std::string objection(const std::string& segments, const ChamberLimits& chamber = kChamber) {
  const auto checked = check_profile(parsed(segments), chamber);
  if (checked) return "nothing";
  EXPECT_EQ(checked.error().kind, FaultKind::bad_file);
  return text(checked.error());
}

TEST(Check, AllowsExactLimitsOfChamber) {
  EXPECT_EQ(
      objection(kHold20 +
                "[[segment]]\nkind = \"ramp\"\nto = 70\nrate = 6\n[[segment]]\nkind = \"ramp\"\nto = -45\nrate = 4\n"),
      "nothing");
  EXPECT_EQ(objection(kHold20 + "[[segment]]\nkind = \"ramp\"\nto = 20.1\ntime = \"1 s\"\n"), "nothing");
}

TEST(Check, AppliesSeparateRatesToHeatingAndCooling) {
  EXPECT_EQ(objection(kHold20 + "[[segment]]\nkind = \"ramp\"\nto = 30\nrate = 5\n"), "nothing");
  EXPECT_EQ(objection(kHold20 + "[[segment]]\nkind = \"ramp\"\nto = 10\nrate = 5\n"),
            "p.toml:8:1: 5 °C/min is faster than the chamber cools, expected at most 4 °C/min");
}

TEST(Check, ReportsAllErrorsOnce) {
  EXPECT_EQ(objection(R"([[segment]]
kind = "hold"
at = 80
time = "2 h"
deadline = "1 h"
[[segment]]
kind = "repeat"
rates = [2, 7]
  [[segment.segment]]
  kind = "ramp"
  to = -50
  [[segment.segment]]
  kind = "ramp"
  to = 60
)"),
            "p.toml:4:1: 80 °C is outside the chamber's range, expected -45 to 70 °C\n"
            "p.toml:4:1: deadline too short: 3600 s, expected at least the 7200 s that the segment takes\n"
            "p.toml:12:3: -50 °C is outside the chamber's range, expected -45 to 70 °C\n"
            "p.toml:12:3: 7 °C/min is faster than the chamber cools, expected at most 4 °C/min\n"
            "p.toml:15:3: 7 °C/min is faster than the chamber heats, expected at most 6 °C/min");
}

TEST(Check, RefusesTemperatureAtAirLimit) {
  const auto p = parsed(kHold20);
  EXPECT_TRUE(check_run_limits(p, "air", {20}, {20}));
  const auto verdict = check_run_limits(p, "air", {-60}, {15});
  ASSERT_FALSE(verdict);
  EXPECT_EQ(text(verdict.error()),
            "p.toml:4:1: 20 °C is outside the rig's air limits, at which a run ends, expected -60 to 15 °C");
}

TEST(Check, RefusesDeadlineShorterThanSoak) {
  const std::string soak = "guaranteed_soak = true\nsoak_time = \"300 s\"\n";
  EXPECT_EQ(objection(kHold20 + soak + "deadline = \"300 s\"\n"), "nothing");
  EXPECT_EQ(objection(kHold20 + soak + "deadline = \"299 s\"\n"),
            "p.toml:4:1: deadline too short: 299 s, expected at least the 300 s that the segment takes");
}

const std::string kRandomOfAnHour = kHold20 + R"([[segment]]
kind = "random"
seed = 1
duration = "1 h"
targets = [[0, 10], [30, 40]]
rates = [1, 4]
hold = ["1 min", "5 min"]
)";

TEST(Check, RefusesHoldThatNoRampReaches) {
  const std::string warm = "[[segment]]\nkind = \"hold\"\nat = 60\ntime = \"5 min\"\n";
  const std::string said =
      "the set point is 20 °C before this hold at 60 °C, so the hold's time would begin before the set point arrives; "
      "expected a ramp before it, or guaranteed_soak = true";
  EXPECT_EQ(objection(kHold20 + warm), "p.toml:8:1: " + said);
  EXPECT_EQ(objection(kHold20 + warm + "guaranteed_soak = true\n"), "nothing");
  EXPECT_EQ(objection("[defaults]\nguaranteed_soak = true\n" + kHold20 + warm), "nothing");
  EXPECT_EQ(objection(kHold20 + "[[segment]]\nkind = \"ramp\"\nto = 60\nrate = 4\n" + warm), "nothing");
  EXPECT_EQ(objection(kHold20 + kHold20), "nothing");
}

TEST(Check, RefusesPassThatBeginsElsewhereThanPreviousEnds) {
  const auto passes = [](const std::string& count) {
    return "[[segment]]\nkind = \"repeat\"\ncount = " + count +
           "\n[[segment.segment]]\nkind = \"hold\"\nat = 20\ntime = \"1 min\"\n"
           "[[segment.segment]]\nkind = \"ramp\"\nto = 30\nrate = 1\n";
  };
  EXPECT_EQ(objection(passes("1")), "nothing");
  EXPECT_TRUE(objection(passes("3")).starts_with("p.toml:7:1: the set point is 30 °C before this hold at 20 °C"));
}

TEST(Check, HoldsOfRandomProgramAreAtEndsOfRamps) { EXPECT_EQ(objection(kRandomOfAnHour), "nothing"); }

TEST(Check, RefusesSoakKeyWithoutSoak) {
  const std::string keys = "soak_time = \"5 h\"\nsoak_dwell = \"3 h\"\nsoak_sensor = \"A\"\n";
  EXPECT_EQ(objection(kHold20 + keys),
            "p.toml:4:1: soak_time, soak_sensor, soak_dwell has no effect without a guaranteed soak, expected "
            "guaranteed_soak = true with it");
  EXPECT_EQ(objection(kHold20 + keys + "guaranteed_soak = true\n"), "nothing");
  EXPECT_EQ(objection(kRandomOfAnHour + "soak_band = 1\n"),
            "p.toml:8:1: soak_band has no effect without a guaranteed soak, expected guaranteed_soak = true with it");
  EXPECT_EQ(objection("[defaults]\nsoak_band = 1\nsoak_slope = 0.1\n" + kHold20), "nothing");
}

TEST(Check, SoakOfRandomHoldHasDrawnLength) {
  const auto p = parsed("[defaults]\nguaranteed_soak = true\nsoak_time = \"2 h\"\n" + kRandomOfAnHour);
  EXPECT_EQ(p.segments[0].soak_time, std::chrono::hours(2));
  ASSERT_EQ(p.segments[2].kind, SegmentKind::hold);
  EXPECT_EQ(p.segments[2].soak_time, p.segments[2].duration);
}

}  // namespace
}  // namespace gyrotherm::profile
