// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/machine.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::profile {
namespace {

using std::chrono::seconds;

/// Returns a profile: 100 s at 20 °C, 60 s to 25 °C, and 100 s there as a guaranteed soak within 2 K with
/// `soak_keys`.
Profile profile_with(const std::string& soak_keys) {
  return parsed(kHold20 + R"([[segment]]
kind = "ramp"
to = 25
rate = 5
[[segment]]
kind = "hold"
time = "100 s"
guaranteed_soak = true
)" + soak_keys);
}

/// Returns profile_with() with a deadline of 200 s.
Profile soak_profile() { return profile_with("deadline = \"200 s\"\n"); }

ProfileState advance(const Profile& profile, ProfileState state, int steps, std::optional<Celsius> air,
                     Duration each = kSecond) {
  for (int i = 0; i < steps; ++i) state = next(profile, state, {each, air});
  return state;
}

ProfileState state_at_soak(const Profile& profile) { return advance(profile, begin(profile), 160, Celsius{20}); }

TEST(Machine, BeginsWithFirstSecondOfFirstSegment) {
  const auto profile = soak_profile();
  const auto state = begin(profile);
  ASSERT_TRUE(std::holds_alternative<Holding>(state));
  EXPECT_EQ(profile_position(profile, state),
            (ProfilePosition{.segment = 0, .cycle = -1, .phase = Phase::holding, .set_point = Celsius{20}}));
}

TEST(Machine, CompletesTimedSegmentsWithoutAirReading) {
  const auto profile = soak_profile();
  const auto state = advance(profile, begin(profile), 100, std::nullopt);
  ASSERT_TRUE(std::holds_alternative<Ramping>(state));
  EXPECT_EQ(std::get<Ramping>(state).segment, 1);
  EXPECT_EQ(std::get<Ramping>(state).elapsed, Duration::zero());
}

TEST(Machine, CarriesRemainderOfLongSecondIntoNextSegment) {
  const auto profile = soak_profile();
  const auto ramp = std::get<Ramping>(next(profile, begin(profile), {seconds(107), Celsius{20}}));
  EXPECT_EQ(ramp.elapsed, seconds(7));
  const auto hold = std::get<Holding>(next(profile, begin(profile), {seconds(175), Celsius{25}}));
  EXPECT_EQ(hold.segment, 2);
  EXPECT_EQ(hold.elapsed, seconds(15));
  EXPECT_EQ(hold.soaked, Duration::zero());
}

TEST(Ramp, SetPointIsLinearInTime) {
  const auto profile = soak_profile();
  auto state = advance(profile, begin(profile), 100, Celsius{20});
  for (int s = 0; s < 60; ++s, state = next(profile, state, {kSecond, std::nullopt}))
    EXPECT_NEAR(demanded_set_point(profile, state).value, 20 + s * 5 / 60.0, 1e-12);
  EXPECT_EQ(demanded_set_point(profile, state), Celsius{25});
}

TEST(Soak, TakesNoLongerThanHoldWhenAirIsInBand) {
  const auto profile = soak_profile();
  EXPECT_FALSE(std::holds_alternative<Complete>(advance(profile, state_at_soak(profile), 99, Celsius{25})));
  EXPECT_TRUE(std::holds_alternative<Complete>(advance(profile, state_at_soak(profile), 100, Celsius{25})));
}

TEST(Soak, CountsOnlyTimeInBand) {
  const auto profile = soak_profile();
  auto state = advance(profile, state_at_soak(profile), 30, Celsius{23});  // the edge counts
  EXPECT_EQ(std::get<Holding>(state).soaked, seconds(30));
  state = advance(profile, state, 20, Celsius{22.99});
  EXPECT_EQ(std::get<WaitingForSoak>(state).soaked, seconds(30));
  EXPECT_EQ(std::get<WaitingForSoak>(state).elapsed, seconds(50));
  state = advance(profile, state, 69, Celsius{27});
  EXPECT_EQ(std::get<Holding>(state).soaked, seconds(99));
  EXPECT_TRUE(std::holds_alternative<Complete>(next(profile, state, {kSecond, Celsius{25}})));
}

/// Returns profile_with() with a soak that counts only after 30 s in the band, and below 0.5 °C/min.
Profile profile_with_dwell() {
  return profile_with(R"(soak_sensor = "A"
soak_dwell = "30 s"
soak_slope = "0.5 °C/min"
)");
}

ProfileState advance_at(const Profile& profile, ProfileState state, int steps, double celsius, double slope) {
  for (int i = 0; i < steps; ++i) state = next(profile, state, {kSecond, Celsius{celsius}, CelsiusPerMinute{slope}});
  return state;
}

TEST(Soak, CountsOnlyAfterUninterruptedDwellInBand) {
  const auto profile = profile_with_dwell();
  auto state = advance_at(profile, state_at_soak(profile), 30, 25, 0);
  EXPECT_EQ(std::get<WaitingForSoak>(state).soaked, Duration::zero());
  state = advance_at(profile, state, 10, 25, 0);
  EXPECT_EQ(std::get<Holding>(state).soaked, seconds(10));
  state = advance_at(profile, state, 1, 28, 0);
  state = advance_at(profile, state, 30, 25, 0);
  EXPECT_EQ(std::get<WaitingForSoak>(state).soaked, seconds(10)) << "the dwell restarts";
  EXPECT_FALSE(std::holds_alternative<Complete>(advance_at(profile, state, 89, 25, 0)));
  EXPECT_TRUE(std::holds_alternative<Complete>(advance_at(profile, state, 90, 25, 0)));
}

TEST(Soak, CountsOnlyWhileSensorIsStable) {
  const auto profile = profile_with_dwell();
  auto state = advance_at(profile, state_at_soak(profile), 40, 25, 0);
  ASSERT_EQ(std::get<Holding>(state).soaked, seconds(10));
  state = advance_at(profile, state, 20, 25, -0.51);
  EXPECT_EQ(std::get<WaitingForSoak>(state).soaked, seconds(10));
  state = advance_at(profile, state, 20, 25, 0.5);
  EXPECT_EQ(std::get<Holding>(state).soaked, seconds(30));
  state = next(profile, state, {kSecond, Celsius{25}, std::nullopt});
  EXPECT_EQ(std::get<WaitingForSoak>(state).soaked, seconds(30)) << "an unknown slope does not count";
}

TEST(Soak, NamesItsSensor) {
  const auto profile = profile_with_dwell();
  EXPECT_EQ(soak_sensor(profile, begin(profile)), "air");
  EXPECT_EQ(soak_sensor(profile, state_at_soak(profile)), "A");
  EXPECT_TRUE(check_sensors(profile, {"A", "B"}));
  const auto refused = check_sensors(profile, {"B", "shell"});
  ASSERT_FALSE(refused);
  EXPECT_NE(text(refused.error()).find("soak_sensor is \"A\", expected \"air\" or a channel of the rig: B, shell"),
            std::string::npos)
      << text(refused.error());
}

TEST(Soak, DoesNotCountWhileAirIsUnknown) {
  const auto profile = soak_profile();
  const auto state = advance(profile, state_at_soak(profile), 5, std::nullopt);
  EXPECT_EQ(std::get<WaitingForSoak>(state).soaked, Duration::zero());
}

TEST(Soak, IsNeverShorterThanTimeOfHold) {
  const auto profile = parsed(kHold20 + "guaranteed_soak = true\nsoak_time = \"10 s\"\n");
  EXPECT_FALSE(std::holds_alternative<Complete>(advance(profile, begin(profile), 99, Celsius{20})));
  EXPECT_TRUE(std::holds_alternative<Complete>(advance(profile, begin(profile), 100, Celsius{20})));
}

TEST(Soak, RemainsOverdueAfterDeadline) {
  const auto profile = soak_profile();
  auto state = advance(profile, state_at_soak(profile), 200, Celsius{20});
  EXPECT_TRUE(std::holds_alternative<WaitingForSoak>(state));
  state = next(profile, state, {kSecond, Celsius{20}});
  ASSERT_TRUE(std::holds_alternative<Overdue>(state));
  const auto before = profile_position(profile, state);
  EXPECT_EQ(profile_position(profile, advance(profile, state, 1000, Celsius{25})), before);
  EXPECT_EQ(demanded_set_point(profile, state), Celsius{25});
}

TEST(Soak, KeepsSoakTimeWhenDeadlineIsRestarted) {
  const auto profile = soak_profile();
  auto state = advance(profile, state_at_soak(profile), 20, Celsius{25});
  EXPECT_EQ(profile_position(profile, restart_deadline(state)), profile_position(profile, state))
      << "the segment was not overdue";
  state = restart_deadline(advance(profile, state, 181, Celsius{20}));
  EXPECT_EQ(profile_position(profile, state).soaked, std::chrono::seconds(20));
  EXPECT_FALSE(std::holds_alternative<Overdue>(advance(profile, state, 180, Celsius{20})));
  EXPECT_TRUE(std::holds_alternative<Overdue>(advance(profile, state, 181, Celsius{20})));
}

TEST(Machine, KeepsLastSetPointWhenComplete) {
  const auto profile = soak_profile();
  const auto state = advance(profile, state_at_soak(profile), 150, Celsius{25});
  EXPECT_TRUE(std::holds_alternative<Complete>(state));
  EXPECT_EQ(demanded_set_point(profile, state), Celsius{25});
  EXPECT_EQ(time_left(profile, state), Duration::zero());
  EXPECT_EQ(profile_position(profile, state).segment, 2);
}

TEST(TimeLeft, DecreasesBySecondInEachCountedSecond) {
  const auto profile = soak_profile();
  auto state = begin(profile);
  for (auto left = seconds(260); left > seconds(0); left -= seconds(1)) {
    EXPECT_EQ(time_left(profile, state), left);
    state = next(profile, state, {kSecond, Celsius{25}});
  }
  EXPECT_EQ(time_left(profile, state), Duration::zero());
}

TEST(TimeLeft, IsConstantWhileSoakWaits) {
  const auto profile = soak_profile();
  EXPECT_EQ(time_left(profile, advance(profile, state_at_soak(profile), 50, Celsius{20})), seconds(100));
}

TEST(ProfilePosition, RestoresState) {
  const auto profile = soak_profile();
  for (unsigned seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    auto state = begin(profile);
    for (int i = 0; i < 300; ++i) {
      const auto progress = profile_position(profile, state);
      const auto back = restore_state(profile, progress);
      ASSERT_TRUE(back.has_value()) << text(back.error());
      ASSERT_EQ(back->index(), state.index());
      ASSERT_EQ(profile_position(profile, *back), progress);
      std::optional<Celsius> air;
      if (random() % 8 != 0) air = Celsius{20 + static_cast<double>(random() % 70) / 10};
      const Observation seen{Duration(random() % 3'000'000'000), air};
      ASSERT_EQ(profile_position(profile, next(profile, *back, seen)),
                profile_position(profile, next(profile, state, seen)));
      state = next(profile, state, seen);
    }
  }
}

TEST(ProfilePosition, IsRefusedForAnotherProfile) {
  const auto profile = soak_profile();
  const auto refused = [&](int segment, Phase phase, Duration in_segment = {}) {
    ProfilePosition progress;
    progress.segment = segment;
    progress.phase = phase;
    progress.in_segment = in_segment;
    const auto state = restore_state(profile, progress);
    EXPECT_TRUE(state || state.error().kind == FaultKind::mismatch);
    return state ? "nothing" : state.error().what;
  };
  EXPECT_EQ(refused(3, Phase::holding), "segment 4 of 3");
  EXPECT_EQ(refused(-1, Phase::complete), "segment 0 of 3");
  EXPECT_EQ(refused(0, Phase::ramping), "segment 1 cannot be ramping");
  EXPECT_EQ(refused(0, Phase::waiting_for_soak), "segment 1 cannot be waiting for soak");
  EXPECT_EQ(refused(1, Phase::ramping, seconds(60)), "segment 2 is past its end");
  EXPECT_EQ(refused(0, Phase::holding, seconds(-1)), "segment 1 has a negative time");
}

}  // namespace
}  // namespace gyrotherm::profile
