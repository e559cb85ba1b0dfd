// SPDX-License-Identifier: Apache-2.0
/// Tests profiles of runs that end by themselves: errors of `[until]`, and the growth by released blocks.
#include "sequencer/profile/released_blocks.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "sequencer/profile/machine.hpp"
#include "sequencer/profile/warm_up.hpp"
#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::profile {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

std::string ramp(const std::string& table, const std::string& keys) {
  return "[[" + table + "]]\nkind = \"ramp\"\n" + keys;
}
std::string hold(const std::string& table, const std::string& keys) {
  return "[[" + table + "]]\nkind = \"hold\"\n" + keys;
}

const std::string kOpening = hold("segment", "at = 20\ntime = \"10 min\"\n");
const std::string kHead = "[until]\nu_deg_per_h = 0.01\nmission = \"ship\"\nlongest = \"5 h\"\n";
const std::string kCold = "[[until.block]]\nname = \"cold\"\n" + ramp("until.block.segment", "to = -20\nrate = 4\n") +
                          hold("until.block.segment", "time = \"15 min\"\n");
const std::string kHot = "[[until.block]]\nname = \"hot\"\n" +
                         ramp("until.block.segment", "to = 40\ntime = \"10 min\"\n") +
                         hold("until.block.segment", "time = \"10 min\"\n");
const std::string kClosing = ramp("until.closing.segment", "to = 20\nrate = 2\n");

std::vector<std::string> names(const std::vector<Segment>& segments) {
  std::vector<std::string> all;
  for (const auto& segment : segments) all.push_back(segment.name);
  return all;
}

struct WrongUntil {
  std::string text;  ///< the opening is in lines 4 to 7; [until] begins in line 8
  std::string said;
};
void PrintTo(const WrongUntil& wrong, std::ostream* os) { *os << wrong.text; }

class UntilMistake : public testing::TestWithParam<WrongUntil> {};
TEST_P(UntilMistake, IsReportedWithPosition) { EXPECT_EQ(profile_errors(kOpening + GetParam().text), GetParam().said); }

INSTANTIATE_TEST_SUITE_P(
    Until, UntilMistake,
    testing::Values(
        WrongUntil{"[until]\n" + kCold,
                   "p.toml:8:1: missing key \"u_deg_per_h\", expected a number\n"
                   "p.toml:8:1: missing key \"mission\", expected text\n"
                   "p.toml:8:1: missing key \"longest\", expected a duration like \"2 h\" or \"90 s\""},
        WrongUntil{kHead, "p.toml:8:1: no block, expected at least one [[until.block]]"},
        WrongUntil{"[until]\nu_deg_per_h = -1\nmission = \"\"\nlongest = \"5 h\"\n" + kCold,
                   "p.toml:9:15: \"u_deg_per_h\" is -1 °/h, expected more than 0 °/h\n"
                   "p.toml:10:11: \"mission\" is empty, expected a profile"},
        WrongUntil{kHead + "u_until = 1\n" + kCold, "p.toml:12:1: unknown key \"u_until\""},
        WrongUntil{kHead + kCold + kCold, "p.toml:22:8: a block \"cold\" exists already, expected another name"},
        WrongUntil{kHead + "[[until.block]]\nname = \"a\\\"b\"\n" + kCold.substr(kCold.find("[[until.block.seg")),
                   "p.toml:13:8: \"name\" is not valid, expected 1 to 60 bytes without quotation marks"},
        WrongUntil{kHead + "[[until.block]]\nname = \"x\"\n", "p.toml:12:1: no segment, expected at least one"},
        WrongUntil{
            kHead + "[[until.block]]\nname = \"x\"\n" + hold("until.block.segment", "at = 20\ntime = \"15 min\"\n"),
            "p.toml:15:8: the first segment of a block is not a ramp, expected one"},
        WrongUntil{kHead + "[[until.block]]\nname = \"x\"\n" + ramp("until.block.segment", "to = 40\nrate = 4\n"),
                   "p.toml:12:1: the block does not end with a hold of at least 10 min, in which the next block is "
                   "chosen"},
        WrongUntil{kHead + "[[until.block]]\nname = \"x\"\n" + ramp("until.block.segment", "to = 20\nrate = 4\n"),
                   "p.toml:12:1: the block does not end with a hold of at least 10 min, in which the next block is "
                   "chosen"},
        WrongUntil{kHead + "[[until.block]]\nname = \"x\"\n" + ramp("until.block.segment", "to = 40\nrate = 4\n") +
                       hold("until.block.segment", "time = \"599 s\"\n"),
                   "p.toml:12:1: the block does not end with a hold of at least 10 min, in which the next block is "
                   "chosen"},
        WrongUntil{kHead + "[[until.block]]\nname = \"x\"\n" + ramp("until.block.segment", "to = 40\nrate = 4\n") +
                       hold("until.block.segment", "time = \"15 min\"\npower = \"off\"\n"),
                   "p.toml:12:1: the block leaves the unit switched off, expected it switched on and as mounted"},
        WrongUntil{kHead + "[[until.block]]\nname = \"x\"\n" + ramp("until.block.segment", "to = 40\nrate = 4\n") +
                       hold("until.block.segment", "time = \"15 min\"\naxis = \"turned\"\n"),
                   "p.toml:21:8: a block cannot turn the unit; expected it in the opening"},
        WrongUntil{kHead + "[[until.block]]\nname = \"x\"\n" + ramp("until.block.segment", "to = 40\nrate = 4\n") +
                       hold("until.block.segment", "time = \"15 min\"\nprompt = \"look\"\ndoor = \"opened\"\n"),
                   "p.toml:22:8: a block cannot open the door; expected it in the opening"},
        WrongUntil{kHead + kCold + "[[until.closing.segment]]\nkind = \"hold\"\ntime = \"1 min\"\n",
                   "p.toml:22:8: the first segment of a block is not a ramp, expected one"},
        WrongUntil{"[until]\nu_deg_per_h = 1\nmission = \"s\"\nlongest = \"9 min\"\n" + kCold,
                   "p.toml:11:11: \"longest\" is 540 s, expected at least the 600 s of opening and closing"},
        WrongUntil{"[until]\nu_deg_per_h = 1\nmission = \"s\"\nlongest = \"20 min\"\n" + kCold,
                   "p.toml:12:1: this block of 900 s never fits between opening and closing into the longest "
                   "duration"}));

TEST(Until, OpeningMustEndWithLongHold) {
  const std::string text = hold("segment", "at = 20\ntime = \"100 s\"\n") + kHead + kCold;
  EXPECT_EQ(profile_errors(text),
            "p.toml:8:1: the opening does not end with a hold of at least 10 min, in which the next block is chosen");
}

TEST(Until, EveryPossibleStartIsExpanded) {
  const auto profile = parsed(kOpening + kHead + kCold + kHot + kClosing);
  ASSERT_TRUE(profile.until);
  EXPECT_EQ(profile.segments.size(), 1u) << "the opening only";
  ASSERT_EQ(profile.until->blocks.size(), 2u);
  const auto& cold = profile.until->blocks[0];
  ASSERT_EQ(cold.expanded.size(), 3u) << "at 20, -20 and 40 °C";
  EXPECT_EQ(names(find_expansion(cold, {20})->segments), (std::vector<std::string>{"ramp to -20 °C", "hold -20 °C"}));
  EXPECT_EQ(find_expansion(cold, {20})->segments[0].duration, minutes(10));
  EXPECT_EQ(find_expansion(cold, {40})->segments[0].duration, minutes(15));
  EXPECT_EQ(names(find_expansion(cold, {-20})->segments), std::vector<std::string>{"hold -20 °C"}) << "already there";
  EXPECT_EQ(find_expansion(cold, {0}), nullptr);
  EXPECT_EQ(find_expansion(profile.until->blocks[1], {-20})->segments[0].rate, CelsiusPerMinute{6});
  EXPECT_TRUE(find_expansion(profile.until->closing, {20})->segments.empty());
  EXPECT_EQ(total_time(find_expansion(profile.until->closing, {40})->segments), minutes(10));
}

/// A ramp in a given time is slow from 20 °C, but from the end of another block too fast.
TEST(Until, LimitsAreCheckedFromEveryStart) {
  const auto profile = parsed(kOpening + kHead + kCold + kHot);
  const ChamberLimits slow{{-45}, {70}, {5}, {5}};
  const auto checked = check_profile(profile, slow);
  ASSERT_FALSE(checked);
  EXPECT_EQ(text(checked.error()), "p.toml:23:1: 6 °C/min is faster than the chamber heats, expected at most 5 °C/min");
  EXPECT_TRUE(check_profile(profile, {{-45}, {70}, {6}, {5}}));
  EXPECT_FALSE(check_profile(profile, {{-10}, {70}, {6}, {5}}));
  EXPECT_FALSE(check_run_limits(profile, "air", {-15}, {70}));
  EXPECT_TRUE(check_run_limits(profile, "air", {-20}, {40}));
  const auto soaked =
      parsed(kOpening + kHead + kCold +
             hold("until.block.segment", "time = \"15 min\"\nguaranteed_soak = true\nsoak_sensor = \"Q\"\n"));
  EXPECT_FALSE(check_sensors(soaked, {"A", "B"}));
  EXPECT_TRUE(check_sensors(soaked, {"A", "Q"}));
}

TEST(Until, ProfileGrowsByReleasedBlocksOnly) {
  auto profile = parsed(kOpening + kHead + kCold + kHot + kClosing);
  EXPECT_TRUE(is_open(profile));
  EXPECT_EQ(names(add_block(profile, "cold").value()), (std::vector<std::string>{"ramp to -20 °C", "hold -20 °C"}));
  EXPECT_EQ(names(add_block(profile, "cold").value()), std::vector<std::string>{"hold -20 °C"});
  const auto before = profile.segments.size();
  const auto refused = add_block(profile, "warm");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::mismatch);
  EXPECT_EQ(profile.segments.size(), before);
  ASSERT_TRUE(add_block(profile, ""));
  EXPECT_FALSE(is_open(profile));
  EXPECT_FALSE(add_block(profile, "hot")) << "it has ended";
  EXPECT_FALSE(add_block(profile, ""));
  EXPECT_EQ(profile.segments.back().target, Celsius{20});
  EXPECT_EQ(profile.added_blocks, (std::vector<std::string>{"cold", "cold", ""}));
}

TEST(Until, SameBlocksRebuildSameProfile) {
  auto grown = parsed(kOpening + kHead + kCold + kHot + kClosing), rebuilt = grown;
  for (const auto* block : {"hot", "cold", "hot", "hot", "cold", ""}) ASSERT_TRUE(add_block(grown, block));
  ASSERT_TRUE(add_blocks(rebuilt, grown.added_blocks));
  ASSERT_EQ(names(rebuilt.segments), names(grown.segments));
  for (std::size_t i = 0; i < grown.segments.size(); ++i) {
    EXPECT_EQ(rebuilt.segments[i].duration, grown.segments[i].duration);
    EXPECT_EQ(rebuilt.segments[i].target, grown.segments[i].target);
  }
  auto fixed = parsed(kOpening);
  EXPECT_FALSE(is_open(fixed));
  EXPECT_TRUE(add_blocks(fixed, {}));
  EXPECT_FALSE(add_blocks(fixed, std::vector<std::string>{"cold"}));
}

TEST(Until, OpenProfileDoesNotEnd) {
  auto profile = parsed(kOpening + kHead + kCold + kClosing);
  auto state = begin(profile);
  for (int i = 0; i < 2000; ++i) state = next(profile, state, {seconds(1), Celsius{20}});
  EXPECT_EQ(profile_position(profile, state).phase, Phase::holding);
  EXPECT_EQ(profile_position(profile, state).in_segment, seconds(599)) << "its clock stopped before the end";
  ASSERT_TRUE(add_block(profile, "cold"));
  state = next(profile, state, {seconds(1), Celsius{20}});
  EXPECT_EQ(profile_position(profile, state).segment, 1);
  ASSERT_TRUE(add_block(profile, ""));
  for (int i = 0; i < 600 + 900 + 1200; ++i) state = next(profile, state, {seconds(1), Celsius{20}});
  EXPECT_TRUE(std::holds_alternative<Complete>(state)) << "after the closing";
}

TEST(Until, SoakThatIsLostAtTheEndKeepsProfileOpen) {
  const auto profile = parsed(hold("segment", "at = 20\ntime = \"10 min\"\nguaranteed_soak = true\n") + kHead + kCold);
  auto state = begin(profile);
  for (int i = 0; i < 700; ++i) state = next(profile, state, {seconds(1), Celsius{20}});
  state = next(profile, state, {seconds(1), Celsius{30}});
  EXPECT_FALSE(std::holds_alternative<Complete>(state));
  EXPECT_FALSE(std::holds_alternative<Overdue>(state));
}

TEST(Until, SuppliesSwitchUnitsOfBlocks) {
  const auto block = "[[until.block]]\nname = \"start\"\n" + ramp("until.block.segment", "to = 30\nrate = 4\n") +
                     hold("until.block.segment", "time = \"5 min\"\npower = \"off\"\n") +
                     hold("until.block.segment", "time = \"20 min\"\npower = \"on\"\n");
  const auto by_hand = parsed(kOpening + kHead + block);
  const auto prompts = [](const Profile& profile) {
    std::vector<std::string> all;
    for (const auto& segment : find_expansion(profile.until->blocks[0], {20})->segments) all.push_back(segment.prompt);
    return all;
  };
  EXPECT_EQ(prompts(by_hand), (std::vector<std::string>{"", "switch the unit off", "switch the unit on"}));
  EXPECT_EQ(prompts(switch_by_supplies(by_hand, {})), (std::vector<std::string>{"", "", ""}));
  EXPECT_EQ(prompts(switch_by_supplies(by_hand, {"u2"})),
            (std::vector<std::string>{"", "switch u2 off", "switch u2 on"}));
}

TEST(Until, WarmUpFollowsColdClosing) {
  const WarmUp warm_up{.at_least = {17}, .air = {25}, .rate = {2}};
  auto without_closing = parsed(kOpening + kHead + kCold + kHot);
  ASSERT_TRUE(add_warm_ups(without_closing, warm_up));
  EXPECT_EQ(without_closing.segments.size(), 1u) << "the opening is not the end";
  const auto& closing = without_closing.until->closing;
  EXPECT_EQ(find_expansion(closing, {-20})->segments.size(), 2u);
  EXPECT_TRUE(find_expansion(closing, {-20})->segments.back().is_warm_up);
  EXPECT_TRUE(find_expansion(closing, {40})->segments.empty());
  ASSERT_TRUE(without_closing.warm_up);
  auto warm = parsed(kOpening + kHead + kCold + kClosing);
  ASSERT_TRUE(add_warm_ups(warm, warm_up));
  EXPECT_EQ(find_expansion(warm.until->closing, {-20})->segments.size(), 1u) << "the closing is warm";
  EXPECT_FALSE(warm.warm_up);
}

TEST(Until, CheckPrintsOpeningBlocksAndClosing) {
  const auto profile = parsed(kOpening + kHead + kCold + kHot + kClosing);
  const auto text = describe(profile, plan(profile));
  for (const auto* part : {"until U = 0.01 °/h on ship, at most 5:00:00", "block \"cold\", 0:25:00:", "ramp to -20 °C",
                           "block \"hot\", 0:20:00:", "closing: nothing"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

}  // namespace
}  // namespace gyrotherm::profile
