// SPDX-License-Identifier: Apache-2.0
/// Warm-ups that a run adds to a profile.
#include "sequencer/profile/warm_up.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "sequencer/profile/machine.hpp"
#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::profile {
namespace {

const std::string kToCold = "[[segment]]\nkind = \"ramp\"\nto = -40\nrate = 2\n";
const std::string kColdHold = "[[segment]]\nkind = \"hold\"\ntime = \"100 s\"\n";
const std::string kTurned = kColdHold + "axis = \"turned\"\n";
const WarmUp kWarmUp = make_warm_up({}, {.lowest = {-45}, .highest = {70}, .fastest_heating = {6}});

Profile with_warm_ups(const std::string& segments, const WarmUp& warm_up = kWarmUp) {
  auto profile = parsed(segments);
  EXPECT_TRUE(add_warm_ups(profile, warm_up));
  return profile;
}

TEST(WarmUp, IsMarginAboveDewPointOfRoom) {
  EXPECT_DOUBLE_EQ(kWarmUp.at_least.value, 16.8);
  EXPECT_DOUBLE_EQ(kWarmUp.air.value, 25);
  EXPECT_DOUBLE_EQ(kWarmUp.rate.value, 2);
  const auto humid = make_warm_up({.dew_point = {26}}, {.highest = {70}, .fastest_heating = {1}});
  EXPECT_DOUBLE_EQ(humid.at_least.value, 28);
  EXPECT_DOUBLE_EQ(humid.air.value, 33);
  EXPECT_DOUBLE_EQ(humid.rate.value, 1) << "the chamber heats no faster";
}

TEST(WarmUp, FollowsProfileThatEndsCold) {
  const auto profile = with_warm_ups(kHold20 + kToCold + kColdHold);
  ASSERT_EQ(profile.segments.size(), 5u);
  const auto& ramp = profile.segments[3];
  const auto& wait = profile.segments[4];
  EXPECT_EQ(ramp.kind, SegmentKind::ramp);
  EXPECT_DOUBLE_EQ(ramp.target.value, 25);
  EXPECT_EQ(ramp.duration, std::chrono::minutes(33)) << "65 K at 2 °C/min take 32.5 min";
  EXPECT_TRUE(wait.guaranteed_soak && wait.is_warm_up);
  EXPECT_EQ(wait.soak_sensor, kColdestThermometer);
  EXPECT_TRUE(profile.warm_up);
  EXPECT_TRUE(check_profile(profile, {.lowest = {-45}, .highest = {70}}));
  EXPECT_TRUE(check_sensors(profile, {"A"})) << "the coldest thermometer is no channel";
}

TEST(WarmUp, IsAbsentFromProfileThatEndsWarm) {
  for (const auto& segments : {kHold20, kHold20 + kToCold + "[[segment]]\nkind = \"ramp\"\nto = 17\nrate = 2\n",
                               "[condensation]\nwarm_up = false\n" + kHold20 + kToCold}) {
    const auto profile = with_warm_ups(segments);
    EXPECT_EQ(profile.segments.size(), parsed(segments).segments.size());
    EXPECT_FALSE(profile.warm_up);
  }
}

TEST(WarmUp, PrecedesPromptThatOpensDoor) {
  const auto profile = with_warm_ups(kHold20 + kToCold + kColdHold + kTurned + kColdHold +
                                     "[[segment]]\nkind = \"ramp\"\nto = 20\nrate = 2\n");
  ASSERT_EQ(profile.segments.size(), 9u);
  EXPECT_EQ(profile.segments[3].name, "warm-up to 25 °C");
  EXPECT_FALSE(profile.segments[4].unit.turned) << "the unit is turned when it is warm";
  const auto& back = profile.segments[5];
  EXPECT_DOUBLE_EQ(back.target.value, -40);
  EXPECT_NE(back.prompt.find("turn the unit around"), std::string::npos);
  EXPECT_TRUE(back.unit.turned);
  EXPECT_EQ(profile.segments[6].prompt, "") << "the prompt is answered once";
  EXPECT_TRUE(profile.segments[6].unit.turned);
  EXPECT_TRUE(check_profile(profile, {}));
}

TEST(WarmUp, DependsOnDoorOfPrompt) {
  const auto cold = kHold20 + kToCold, warm = "[[segment]]\nkind = \"ramp\"\nto = 20\nrate = 2\n" + kColdHold;
  const auto asks = kColdHold + "prompt = \"change the cable\"\n";
  EXPECT_EQ(with_warm_ups(cold + asks + warm).segments.size(), 5u) << "a task outside the chamber";
  EXPECT_EQ(with_warm_ups(cold + asks + "door = \"opened\"\n" + warm).segments.size(), 8u);
  EXPECT_EQ(with_warm_ups(cold + kTurned + "door = \"closed\"\n" + warm).segments.size(), 5u) << "turned from outside";
  EXPECT_EQ(with_warm_ups(kHold20 + asks + "door = \"opened\"\n").segments.size(), 2u) << "the set point is 20 °C";
  EXPECT_EQ(profile_errors(kHold20 + "door = \"opened\"\n"),
            "p.toml:8:8: the door is opened without a prompt, expected \"prompt\" or \"axis\" with it");
}

TEST(WarmUp, WaitsForColdestThermometer) {
  const auto profile = with_warm_ups(kHold20 + kToCold);
  ProfileState state = WaitingForSoak{.segment = 3};
  EXPECT_EQ(soak_sensor(profile, state), kColdestThermometer);
  const auto pass = [&](std::optional<Celsius> coldest, int count) {
    for (int i = 0; i < count; ++i) state = next(profile, state, {.elapsed = kSecond, .air = coldest});
  };
  pass(Celsius{16.7}, 3600);
  pass(std::nullopt, 600);
  EXPECT_TRUE(std::holds_alternative<WaitingForSoak>(state));
  pass(Celsius{16.8}, 59);
  EXPECT_FALSE(std::holds_alternative<Complete>(state));
  pass(Celsius{60}, 1);
  EXPECT_TRUE(std::holds_alternative<Complete>(state)) << "a warmer unit is warm enough";
}

TEST(WarmUp, IsRefusedIfChamberIsTooCold) {
  auto profile = parsed(kHold20 + kToCold);
  const auto added = add_warm_ups(profile, make_warm_up({}, {.highest = {15}}));
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().kind, FaultKind::usage);
  EXPECT_EQ(profile.segments.size(), 2u);
  auto warm = parsed(kHold20);
  EXPECT_TRUE(add_warm_ups(warm, make_warm_up({}, {.highest = {15}}))) << "no warm-up is required";
}

TEST(WarmUp, IsListedInTimeline) {
  const auto profile = with_warm_ups(kHold20 + kToCold);
  const auto text = describe(profile, plan(profile));
  EXPECT_NE(text.find("warm-up to 25 °C"), std::string::npos) << text;
  EXPECT_NE(text.find("coldest thermometer at 16.8 °C or more, at most 12:00:00"), std::string::npos) << text;
}

}  // namespace
}  // namespace gyrotherm::profile
