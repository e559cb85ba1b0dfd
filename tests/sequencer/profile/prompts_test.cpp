// SPDX-License-Identifier: Apache-2.0
/// Prompts: tasks in a profile for the operator.
#include <gtest/gtest.h>

#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::profile {
namespace {

std::string hold(const std::string& more) { return "[[segment]]\nkind = \"hold\"\ntime = \"100 s\"\n" + more; }
const std::string kWayUp = "[[segment]]\nkind = \"ramp\"\nto = 30\nrate = 1\n";

TEST(Prompts, AreRequiredWhereUnitChanges) {
  const auto p = parsed(kHold20 + hold("power = \"off\"\n") + kWayUp + hold("power = \"on\"\naxis = \"turned\"\n") +
                        hold("") + hold("axis = \"as mounted\"\nprompt = \"turn it back; close the door\"\n"));
  ASSERT_EQ(p.segments.size(), 6u);
  EXPECT_EQ(p.segments[0].prompt, "");
  EXPECT_EQ(p.segments[0].unit, UnitState{});
  EXPECT_EQ(p.segments[1].prompt, "switch the unit off");
  EXPECT_EQ(p.segments[1].unit, (UnitState{.off = true}));
  EXPECT_EQ(p.segments[2].prompt, "") << "a ramp has no prompt";
  EXPECT_EQ(p.segments[2].unit, (UnitState{.off = true})) << "and does not change the unit";
  EXPECT_EQ(p.segments[3].prompt, "switch the unit on and turn the unit around: its input axis points the other way");
  EXPECT_EQ(p.segments[3].unit, (UnitState{.turned = true}));
  EXPECT_EQ(p.segments[4].prompt, "");
  EXPECT_EQ(p.segments[4].unit, (UnitState{.turned = true}));
  EXPECT_EQ(p.segments[5].prompt, "turn it back; close the door");
  EXPECT_EQ(p.segments[5].unit, UnitState{});
}

TEST(Prompts, AreInEachPassOfRepeat) {
  const auto p = parsed(kHold20 + R"(
[[segment]]
kind = "repeat"
count = 2
  [[segment.segment]]
  kind = "hold"
  time = "1 min"
  power = "off"
  [[segment.segment]]
  kind = "hold"
  time = "1 min"
  power = "on"
)");
  ASSERT_EQ(p.segments.size(), 5u);
  EXPECT_EQ(p.segments[3].prompt, "switch the unit off");
  EXPECT_EQ(p.segments[4].prompt, "switch the unit on");
}

TEST(Prompts, AreListed) {
  const auto p = parsed(kHold20 + hold("prompt = \"look at the window\"\n"));
  EXPECT_TRUE(describe(p, plan(p)).ends_with("segment 2 waits for the operator: look at the window\n"));
}

TEST(Prompts, RefuseTextOfSeveralLines) {
  EXPECT_EQ(profile_errors(kHold20 + hold("prompt = \"\"\n")),
            "p.toml:11:10: \"prompt\" is empty, expected a task for the operator");
  EXPECT_EQ(profile_errors(kHold20 + hold("prompt = \"a\\u001b[2J\"\n")),
            "p.toml:11:10: \"prompt\" has control characters, expected one line of text");
  EXPECT_EQ(profile_errors(kHold20 + hold("prompt = \"" + std::string(501, 'x') + "\"\n")),
            "p.toml:11:10: \"prompt\" is 501 bytes long, expected at most 500");
  EXPECT_NE(profile_errors(kHold20 + kWayUp + "prompt = \"look\"\n"), "nothing");
  EXPECT_NE(profile_errors(kHold20 + hold("axis = \"upside down\"\n")), "nothing");
  EXPECT_NE(profile_errors(kHold20 + hold("power = 1\n")), "nothing");
}

TEST(Prompts, RefuseTurnOfFixedUnit) {
  const auto p = parsed(kHold20 + hold("axis = \"turned\"\n"));
  EXPECT_TRUE(check_turns(p, true));
  const auto refused = check_turns(p, false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()),
            "p.toml:8:1: the unit is turned here, expected a rig with \"can_be_turned\" in [gyro]");
  EXPECT_TRUE(check_turns(parsed(kHold20 + hold("power = \"off\"\n")), false));
}

}  // namespace
}  // namespace gyrotherm::profile
