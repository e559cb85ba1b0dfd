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

TEST(Check, AllowsWhatTheChamberCanDoExactly) {
  EXPECT_EQ(
      objection(kHold20 +
                "[[segment]]\nkind = \"ramp\"\nto = 70\nrate = 6\n[[segment]]\nkind = \"ramp\"\nto = -45\nrate = 4\n"),
      "nothing");
  EXPECT_EQ(objection(kHold20 + "[[segment]]\nkind = \"ramp\"\nto = 20.1\ntime = \"1 s\"\n"), "nothing");
}

TEST(Check, HeatingAndCoolingHaveTheirOwnRates) {
  EXPECT_EQ(objection(kHold20 + "[[segment]]\nkind = \"ramp\"\nto = 30\nrate = 5\n"), "nothing");
  EXPECT_EQ(objection(kHold20 + "[[segment]]\nkind = \"ramp\"\nto = 10\nrate = 5\n"),
            "p.toml:8:1: 5 °C/min is faster than the chamber cools, expected at most 4 °C/min");
}

TEST(Check, TellsEveryMistakeAtOnceAndEachOnce) {
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
            "p.toml:4:1: 80 °C is beyond the chamber, expected -45 to 70 °C\n"
            "p.toml:4:1: deadline too short: 3600 s, expected at least the 7200 s that the segment takes\n"
            "p.toml:12:3: -50 °C is beyond the chamber, expected -45 to 70 °C\n"
            "p.toml:12:3: 7 °C/min is faster than the chamber cools, expected at most 4 °C/min\n"
            "p.toml:15:3: 7 °C/min is faster than the chamber heats, expected at most 6 °C/min");
}

TEST(Check, ATemperatureAtWhichTheAirEndsTheRunIsAMistake) {
  const auto p = parsed(kHold20);
  EXPECT_TRUE(check_air(p, {20}, {20}));
  const auto verdict = check_air(p, {-60}, {15});
  ASSERT_FALSE(verdict);
  EXPECT_EQ(text(verdict.error()),
            "p.toml:4:1: 20 °C is beyond the air's limits of the rig, at which a run ends, expected -60 to 15 °C");
}

TEST(Check, ADeadlineMustLeaveTimeForTheSoak) {
  const std::string soak = "guaranteed_soak = true\nsoak_time = \"300 s\"\n";
  EXPECT_EQ(objection(kHold20 + soak + "deadline = \"300 s\"\n"), "nothing");
  EXPECT_EQ(objection(kHold20 + soak + "deadline = \"299 s\"\n"),
            "p.toml:4:1: deadline too short: 299 s, expected at least the 300 s that the segment takes");
}

}  // namespace
}  // namespace gyrotherm::profile
