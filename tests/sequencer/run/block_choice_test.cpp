// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/block_choice.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>

#include "sequencer/profile/released_blocks.hpp"

namespace gyrotherm::run {
namespace {

using std::chrono::minutes;

constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// A profile with blocks of 30 min ("short"), 2 h ("long") and 30 min ("again"), and 10 min of closing after them. The
/// first two end at 40 °C, the last one at 20 °C.
profile::Profile three_blocks(const std::string& longest = "10 h") {
  const auto block = [](const std::string& name, const std::string& to, const std::string& ramp,
                        const std::string& hold) {
    return "[[until.block]]\nname = \"" + name + "\"\n[[until.block.segment]]\nkind = \"ramp\"\nto = " + to +
           "\ntime = \"" + ramp + "\"\n[[until.block.segment]]\nkind = \"hold\"\ntime = \"" + hold + "\"\n";
  };
  auto profile = profile::parse_profile(
      "schema = \"gyrotherm-profile/1\"\nname = \"p\"\n[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"1 h\"\n"
      "[until]\nu_deg_per_h = 0.01\nmission = \"m\"\nlongest = \"" +
          longest + "\"\n" + block("short", "40", "10 min", "20 min") + block("long", "40", "20 min", "100 min") +
          block("again", "20", "10 min", "20 min") +
          "[[until.closing.segment]]\nkind = \"ramp\"\nto = 25\ntime = \"10 min\"\n",
      "p.toml");
  EXPECT_TRUE(profile) << text(profile.error());
  return *profile;
}

DecisionInputs inputs(double now, std::vector<double> after) {
  return {.number = 4,
          .target_deg_per_h = 0.01,
          .u_now_deg_per_h = now,
          .u_after_deg_per_h = std::move(after),
          .used = minutes(60),
          .hold_left = {}};
}

TEST(BlockChoice, EndsWhenTargetIsMet) {
  for (const auto now : {0.01, 0.002, 0.010004}) {
    const auto decision = decide(three_blocks(), inputs(now, {0.001, 0.001, 0.001}));
    EXPECT_EQ(decision.block, "") << now;
    EXPECT_EQ(decision.end, kMet);
    EXPECT_EQ(decision.number, 4);
  }
  EXPECT_EQ(decide(three_blocks(), inputs(0.0101, {0.001, 0.1, 0.1})).block, "short") << "not yet met";
}

TEST(BlockChoice, ChoosesGreatestDecreasePerHour) {
  // 0.010 in 0.5 h is more per hour than 0.030 in 2 h.
  const auto decision = decide(three_blocks(), inputs(0.1, {0.09, 0.07, 0.095}));
  EXPECT_EQ(decision.block, "short");
  EXPECT_EQ(decision.u_expected_deg_per_h, 0.09);
  EXPECT_EQ(decision.hours_used, 1);
  EXPECT_EQ(decision.hours_left, 9);
  ASSERT_EQ(decision.blocks.size(), 3u);
  EXPECT_EQ(decision.blocks[1].hours, 2);
  EXPECT_EQ(decide(three_blocks(), inputs(0.1, {0.09, 0.05, 0.095})).block, "long");
}

/// A resumed run has slightly other noise. Decreases that differ by less than a tenth do not change a decision.
TEST(BlockChoice, ChoosesFirstOfNearlyEqualBlocks) {
  EXPECT_EQ(decide(three_blocks(), inputs(0.1, {0.09, 0.09, 0.09})).block, "short");
  for (const auto last : {0.0901, 0.09, 0.0899, 0.0891})
    EXPECT_EQ(decide(three_blocks(), inputs(0.1, {0.09, 0.09, last})).block, "short") << last;
  EXPECT_EQ(decide(three_blocks(), inputs(0.1, {0.09, 0.09, 0.0885})).block, "again") << "more than a tenth";
  EXPECT_EQ(decide(three_blocks(), inputs(0.1, {0.0911, 0.09, 0.09})).block, "again");
}

TEST(BlockChoice, IgnoresNoise) {
  for (const auto noise : {-4e-6, 0.0, 4e-6})
    for (const auto other : {-4e-4, 0.0, 4e-4}) {
      const auto decision = decide(three_blocks(), inputs(0.0512 + noise, {0.0431, 0.9, 0.0431 + other}));
      EXPECT_EQ(decision.block, "short");
      EXPECT_EQ(decision.u_now_deg_per_h, 0.0512) << "three digits";
      EXPECT_EQ(decision.u_expected_deg_per_h, 0.0431);
    }
}

TEST(BlockChoice, FollowsGainsWhereTheyAreGiven) {
  auto with_gains = inputs(0.1, {0.05, 0.09, 0.09});
  with_gains.gains = {0.1, 0.1, 0.2};
  EXPECT_EQ(decide(three_blocks(), with_gains).block, "again");
  EXPECT_EQ(decide(three_blocks(), with_gains).u_expected_deg_per_h, 0.09);
  with_gains.gains = {0.004, 0.005, 0};
  EXPECT_EQ(decide(three_blocks(), with_gains).end, kCannotBeMet) << "at most 0.5 %";
  with_gains.u_now_deg_per_h = 0.01;
  EXPECT_EQ(decide(three_blocks(), with_gains).end, kMet);
}

TEST(BlockChoice, EndsWhenNoBlockLowersUncertainty) {
  for (const auto after : {0.1, 0.0996, 0.2, kUnknown}) {
    const auto decision = decide(three_blocks(), inputs(0.1, {after, after, after}));
    EXPECT_EQ(decision.end, kCannotBeMet) << after;
    EXPECT_EQ(decision.block, "");
    EXPECT_EQ(decision.u_expected_deg_per_h, std::nullopt);
  }
  EXPECT_EQ(decide(three_blocks(), inputs(0.1, {0.0994, 0.1, 0.1})).block, "short") << "more than 0.5 %";
}

TEST(BlockChoice, EndsWhenTimeIsUp) {
  auto now = inputs(0.1, {0.05, 0.01, 0.06});
  now.used = minutes(600 - 40);
  EXPECT_EQ(decide(three_blocks(), now).block, "short") << "30 min and 10 min of closing fit exactly";
  EXPECT_FALSE(decide(three_blocks(), now).blocks[1].fits);
  now.hold_left = std::chrono::seconds(1);
  const auto late = decide(three_blocks(), now);
  EXPECT_EQ(late.end, kTimeIsUp);
  EXPECT_EQ(late.hours_left, 0.67);
  now.used = minutes(2000);
  EXPECT_EQ(decide(three_blocks(), now).end, kTimeIsUp);
  EXPECT_EQ(decide(three_blocks(), now).hours_left, 0) << "the run took longer than planned";
}

TEST(BlockChoice, DistinguishesTimeFromUselessBlocks) {
  auto now = inputs(0.1, {0.1, 0.05, 0.1});
  now.used = minutes(600 - 60);
  EXPECT_EQ(decide(three_blocks(), now).end, kTimeIsUp) << "the useful block does not fit";
  now.u_after_deg_per_h = {0.1, 0.1, 0.1};
  EXPECT_EQ(decide(three_blocks(), now).end, kCannotBeMet) << "no block is useful";
}

TEST(BlockChoice, ChoosesLowestUncertaintyWhileNoneIsKnown) {
  const auto decision = decide(three_blocks(), inputs(kUnknown, {0.5, 0.2, kUnknown}));
  EXPECT_EQ(decision.block, "long");
  EXPECT_EQ(decision.u_now_deg_per_h, std::nullopt);
  EXPECT_EQ(decide(three_blocks(), inputs(kUnknown, {kUnknown, kUnknown, kUnknown})).end, kCannotBeMet);
  const auto broken = decide(three_blocks(), inputs(std::numeric_limits<double>::quiet_NaN(), {0.1, 0.1, 0.1}));
  EXPECT_EQ(broken.u_now_deg_per_h, std::nullopt);
  EXPECT_EQ(broken.block, "short");
  EXPECT_EQ(decide(three_blocks(), inputs(kUnknown, {0.105, 0.1, 0.1})).block, "short") << "nearly equal";
}

TEST(BlockChoice, TakesFirstBlockThatFitsWhileRecordIsShort) {
  auto of_short = inputs(kUnknown, {kUnknown, kUnknown, kUnknown});
  of_short.is_record_short = true;
  EXPECT_EQ(decide(three_blocks(), of_short).block, "short");
  EXPECT_FALSE(decide(three_blocks(), of_short).u_expected_deg_per_h);
  of_short.used = minutes(600);
  EXPECT_EQ(decide(three_blocks(), of_short).end, kTimeIsUp);
  of_short.used = minutes(60);
  of_short.u_after_deg_per_h = {kUnknown, 0.3, kUnknown};
  EXPECT_EQ(decide(three_blocks(), of_short).block, "long") << "a known uncertainty";
}

/// The time of a block depends on the set point where it begins, and so does that of the closing after it.
TEST(BlockChoice, CountsTimesFromPresentSetPoint) {
  auto profile = three_blocks();
  ASSERT_TRUE(add_block(profile, "short"));
  const auto decision = decide(profile, inputs(0.1, {0.09, 0.09, 0.09}));
  EXPECT_EQ(decision.blocks[0].hours, 0.33) << "no ramp at 40 °C";
  EXPECT_EQ(decision.blocks[1].hours, 1.67);
  EXPECT_EQ(decision.block, "short");
}

TEST(BlockChoice, EndsBeforeProfileHasTooManySegments) {
  auto profile = three_blocks("1000 h");
  const auto one = profile.segments.front();
  profile.segments.resize(static_cast<std::size_t>(profile::kMaxSegments) - 2, one);
  const auto decision = decide(profile, inputs(0.1, {0.05, 0.05, 0.05}));
  EXPECT_EQ(decision.end, kTimeIsUp);
  EXPECT_TRUE(add_block(profile, "")) << "the closing still fits";
}

}  // namespace
}  // namespace gyrotherm::run
