// SPDX-License-Identifier: Apache-2.0
/// The evidence of a safe chamber, and the reaction to missing evidence: chambers that follow, heat on in manual mode,
/// carry out a program, or switch on again.
#include "sequencer/watchdog/safe_evidence.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <string>

#include "core/file.hpp"

namespace gyrotherm::watchdog {
namespace {

using std::chrono::minutes;

/// A simulated chamber, one second per step, and the commands that it received.
struct Chamber {
  double set_point = 60, air = 60, heats_k = 0.5;
  ChamberActivity activity = ChamberActivity::running;
  bool obeys_mode = true, obeys_off = true;
  std::string commands{};

  void take(SafeAction action) {
    if (action == SafeAction::set_point) set_point = 22, commands += "set ";
    if (action == SafeAction::follow) {
      commands += "follow ";
      if (obeys_mode) activity = ChamberActivity::running;
    }
    if (action == SafeAction::off) {
      commands += "off ";
      if (obeys_off) activity = ChamberActivity::off;
    }
  }
  void second() {
    const bool follows = activity == ChamberActivity::running && heats_k != 0;
    if (activity == ChamberActivity::off || follows)
      air += (22 - air) / 300;
    else
      air += heats_k;
  }
};

const SafeGoal kGoal{.set_point = {22},
                     .tolerance = {0.1},
                     .observe = minutes(5),
                     .shows_mode = true,
                     .shows_off = true,
                     .can_start = true,
                     .can_stop = true};

/// Runs until the chamber is safe. Returns the time in seconds; −1: more than an hour.
int until_safe(SafeEvidence& evidence, Chamber& chamber, const std::function<void(int)>& meanwhile = {}) {
  for (int s = 0; s < 3600; ++s) {
    if (const auto action = evidence.next(); action != SafeAction::keep) {
      chamber.take(action);
      evidence.acknowledge(action);
    }
    chamber.second();
    if (meanwhile) meanwhile(s);
    evidence.add_reading({{chamber.air}, {chamber.set_point}, chamber.activity}, kSecond * (s + 1));
    if (evidence.is_safe()) return s + 1;
  }
  return -1;
}

TEST(SafeEvidence, RequiresSetPointModeAndAir) {
  Chamber chamber;
  SafeEvidence evidence(kGoal);
  EXPECT_EQ(until_safe(evidence, chamber), 301) << evidence.describe();
  EXPECT_EQ(chamber.commands, "set ");
  EXPECT_EQ(evidence.describe().find("set point read back; mode running; air "), 0u) << evidence.describe();
  EXPECT_NE(evidence.describe().find("moves towards 22 °C"), std::string::npos) << evidence.describe();
}

/// Its door stops the chamber only until it is closed.
TEST(SafeEvidence, ChamberToBeSwitchedOffIsNotSafeByOpenDoor) {
  auto goal = kGoal;
  goal.switch_off = true;
  for (const auto activity : {ChamberActivity::door_open, ChamberActivity::alarm})
    for (const bool is_acknowledged : {false, true}) {
      SafeEvidence evidence(goal);
      evidence.acknowledge(SafeAction::set_point);
      if (is_acknowledged) evidence.acknowledge(SafeAction::off);
      for (int second = 1; second <= 900 && !evidence.is_safe(); ++second) {
        evidence.add_reading({{22}, {22}, activity}, kSecond * second);
        if (is_acknowledged && evidence.next() == SafeAction::off) evidence.acknowledge(SafeAction::off);
      }
      EXPECT_EQ(evidence.is_safe(), is_acknowledged) << name(activity);
    }
}

TEST(SafeEvidence, WritesModeOfChamberThatDoesNotFollow) {
  for (const auto activity :
       {ChamberActivity::not_following, ChamberActivity::program, ChamberActivity::holding, ChamberActivity::done}) {
    Chamber chamber{.activity = activity};
    SafeEvidence evidence(kGoal);
    EXPECT_GT(until_safe(evidence, chamber), 300) << name(activity);
    EXPECT_EQ(chamber.commands, "set follow ") << name(activity);
  }
}

TEST(SafeEvidence, SwitchesOffChamberThatHeatsInEveryMode) {
  Chamber chamber{.activity = ChamberActivity::not_following, .obeys_mode = false};
  SafeEvidence evidence(kGoal);
  bool alarmed = false;
  EXPECT_GT(until_safe(evidence, chamber, [&](int) { alarmed = alarmed || evidence.is_ineffective(); }), 300);
  EXPECT_TRUE(alarmed);
  EXPECT_TRUE(chamber.commands.ends_with("off ")) << chamber.commands;
  EXPECT_LT(chamber.air, 75) << "detected within a few kelvins";
  EXPECT_FALSE(evidence.is_ineffective()) << "switching off has helped";
}

TEST(SafeEvidence, SwitchesOffChamberWhoseAirMovesAwayInRightMode) {
  Chamber chamber{.heats_k = 0};  // "running", and does not follow
  SafeEvidence evidence(kGoal);
  EXPECT_GT(until_safe(evidence, chamber), 15 * 60) << "stable air is watched for longer";
  EXPECT_TRUE(chamber.commands.starts_with("set set follow ")) << chamber.commands;
  EXPECT_TRUE(chamber.commands.ends_with("off ")) << chamber.commands;
}

TEST(SafeEvidence, NeverEndsWhileAirMovesAway) {
  Chamber chamber{.activity = ChamberActivity::not_following, .obeys_mode = false, .obeys_off = false};
  SafeEvidence evidence(kGoal);
  EXPECT_EQ(until_safe(evidence, chamber), -1);
  EXPECT_TRUE(evidence.is_ineffective() && evidence.is_exhausted());
  EXPECT_NE(evidence.describe().find("mode NOT shown: not following its set point"), std::string::npos)
      << evidence.describe();
  EXPECT_NE(evidence.describe().find("moved AWAY from 22 °C"), std::string::npos) << evidence.describe();
}

/// The heater sticks at first and is released later: the message follows the air.
TEST(SafeEvidence, DescribesPresentAirAfterMovement) {
  SafeEvidence evidence(kGoal);
  ChamberState chamber{.air = {90}, .set_point = kGoal.set_point, .activity = ChamberActivity::running};
  Duration at{};
  const auto read = [&](double air_c, int times) {
    for (int i = 0; i < times; ++i) evidence.add_reading({{air_c}, kGoal.set_point, chamber.activity}, at += kSecond);
  };
  evidence.acknowledge(SafeAction::set_point);
  read(90, 5);
  EXPECT_EQ(evidence.describe().find("moves AWAY"), std::string::npos) << evidence.describe();
  read(93.5, 2);
  ASSERT_TRUE(evidence.is_ineffective());
  const auto at_once = evidence.describe(at);
  EXPECT_NE(at_once.find("air 93.50 °C; it moved AWAY from 22 °C, from 90.00 °C to 93.50 °C within 6 s"),
            std::string::npos)
      << at_once;
  read(91.25, 60);
  const auto later = evidence.describe(at);
  EXPECT_NE(later.find("air 91.25 °C; 1 min 00 s before it moved AWAY"), std::string::npos) << later;
  EXPECT_EQ(later.find("read "), later.rfind("read back")) << later;
  const auto silent = evidence.describe(at + 40 * kSecond);
  EXPECT_NE(silent.find("(read 40 s ago)"), std::string::npos) << silent;
}

TEST(SafeEvidence, SwitchesOffAgainWhenChamberStartsAgain) {
  auto goal = kGoal;
  goal.switch_off = true;
  Chamber chamber{.air = 22};
  SafeEvidence evidence(goal);
  const auto on_again = [&](int s) {
    if (s == 2 || s == 100) chamber.activity = ChamberActivity::running;
  };
  EXPECT_GT(until_safe(evidence, chamber, on_again), 400) << "the watch restarts";
  EXPECT_EQ(chamber.commands, "set off off off ");
}

TEST(SafeEvidence, SendsSetPointAgainWhenChanged) {
  Chamber chamber;
  SafeEvidence evidence(kGoal);
  const auto change = [&](int s) {
    if (s == 200) chamber.set_point = 60;
  };
  EXPECT_GT(until_safe(evidence, chamber, change), 500);
  EXPECT_EQ(chamber.commands, "set set ");
}

TEST(SafeEvidence, LeavesChamberOffWhenSwitchedOffAtPanel) {
  Chamber chamber{.activity = ChamberActivity::off};
  SafeEvidence evidence(kGoal);
  EXPECT_EQ(until_safe(evidence, chamber), 301) << "an open door is accepted";
  EXPECT_EQ(chamber.commands, "set ");
}

TEST(SafeEvidence, IgnoresUnknownMode) {
  Chamber chamber{.heats_k = 0, .activity = ChamberActivity::unknown};
  SafeEvidence evidence(kGoal);
  EXPECT_GT(until_safe(evidence, chamber), 120 + 300);
  EXPECT_EQ(chamber.commands.find("follow"), std::string::npos) << "the chamber may be off";
  EXPECT_TRUE(chamber.commands.ends_with("off ")) << chamber.commands;
  SafeEvidence falling(kGoal);
  falling.acknowledge(SafeAction::set_point);
  for (int s = 0; s <= 400; ++s) {
    falling.add_reading({{60 - s * 0.05}, {22}, ChamberActivity::unknown}, kSecond * s);
    EXPECT_FALSE(falling.is_safe()) << "only the air, at " << s << " s";
  }
}

TEST(SafeEvidence, UsesOnlyAirWhenMapHasNoStates) {
  const SafeGoal bare{
      .set_point = {22}, .tolerance = {0.1}, .observe = minutes(5), .can_start = true, .can_stop = true};
  SafeEvidence evidence(bare);
  evidence.acknowledge(SafeAction::set_point);
  const auto see = [&](double air, int s) {
    evidence.add_reading({{air}, {std::numeric_limits<double>::quiet_NaN()}, ChamberActivity::unknown}, kSecond * s);
  };
  for (int s = 0; s <= 300; ++s) see(60 - s * 0.05, s);
  EXPECT_TRUE(evidence.is_safe()) << evidence.describe();
  EXPECT_EQ(evidence.describe().find("set point acknowledged; mode not in its map; "), 0u) << evidence.describe();
  SafeEvidence rising(bare);
  rising.acknowledge(SafeAction::set_point);
  for (int s = 0; s <= 30; ++s) rising.add_reading({{60 + s * 0.5}, {22}, ChamberActivity::unknown}, kSecond * s);
  EXPECT_TRUE(rising.is_ineffective());
  EXPECT_TRUE(rising.must_be_off());
}

TEST(SafeEvidence, HasStatesOfEveryShippedMap) {
  int maps = 0, with_mode = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/chambers")) {
    if (entry.path().extension() != ".toml") continue;
    const auto map = drivers::parse_register_map(read_text_file(entry.path().string()).value(), entry.path().string());
    ASSERT_TRUE(map) << text(map.error());
    const auto goal = safe_goal(*map, {22}, minutes(5));
    EXPECT_TRUE(goal.can_start || !goal.can_stop) << entry.path();
    ++maps;
    with_mode += goal.shows_mode ? 1 : 0;
  }
  EXPECT_GE(maps, 12);
  EXPECT_GE(with_mode, 7);
}

}  // namespace
}  // namespace gyrotherm::watchdog
