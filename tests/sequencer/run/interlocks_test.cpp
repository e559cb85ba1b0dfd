// SPDX-License-Identifier: Apache-2.0
#include "sequencer/interlocks/interlocks.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "core/file.hpp"
#include "tests/sequencer/run/interlock_bench.hpp"

namespace gyrotherm::run {
namespace {

using interlocks::InterlockId;
using interlocks::Reaction;

/// Returns a second without faults.
Sample good_sample() {
  Sample sample{.at = {},
                .chamber = {ChamberState{{20}, {20}}, {}},
                .thermometers = {},
                .units = {{.count = {GyroCount{{106}, kSecond}, {}}}},
                .progress = {}};
  for (int i = 0; i < 9; ++i) sample.thermometers.push_back({Celsius{22}, {}});
  return sample;
}

auto no_reply() { return failure(FaultKind::timeout, "instrument", "no reply in 500 ms"); }

/// Judges the same sample repeatedly and returns the last demand.
interlocks::InterlockDemand after(const Sample& sample, int seconds, const interlocks::InterlockLimits& limits = {}) {
  interlocks::InterlockResult result;
  for (int i = 0; i < seconds; ++i) result = judge(limits, result.memory, sample, kSecond);
  return result.demand;
}

TEST(Interlocks, AcceptGoodSecond) { EXPECT_EQ(after(good_sample(), 1000).reaction, interlocks::Reaction::go_on); }

TEST(Interlocks, SuspendWhenChamberIsSilentAndAbortWhenLost) {
  auto sample = good_sample();
  sample.chamber.value = no_reply();
  EXPECT_EQ(after(sample, 4).reaction, interlocks::Reaction::go_on);
  EXPECT_EQ(after(sample, 5).reaction, interlocks::Reaction::suspend);
  EXPECT_EQ(after(sample, 599).reaction, interlocks::Reaction::suspend);
  EXPECT_EQ(after(sample, 600).reaction, interlocks::Reaction::abort);
  EXPECT_EQ(after(sample, 600).cause, "chamber silent for 10 min 00 s");
}

/// A warning that becomes an abort is no longer shelved, suppressed or of low priority.
TEST(Interlocks, RaiseAlarmAgainWhenReactionRises) {
  InterlockBench bench;
  bench.limits.policy[static_cast<std::size_t>(InterlockId::chamber_silent)] = Reaction::warn;
  bench.seconds(10);
  bench.sample.chamber.value = silence();
  EXPECT_GT(bench.seconds_until(Reaction::warn, 100), 0);
  EXPECT_EQ(bench.alarms, 1);
  EXPECT_GT(bench.seconds_until(Reaction::abort, 4000), 0);
  EXPECT_EQ(bench.alarms, 2);
  bench.seconds(100);
  EXPECT_EQ(bench.alarms, 2);
}

TEST(Interlocks, CountSilenceNotAsTimeWithAir) {
  InterlockBench bench;
  bench.seconds(3);
  const auto chamber = bench.sample.chamber;
  bench.sample.chamber.value = silence();
  bench.seconds(60);
  bench.sample.chamber = chamber;
  bench.second();
  EXPECT_LE(bench.memory.explained.watched, kSecond * 6);
  bench.around.missed = kSecond * 7200;
  bench.second(kSecond * 7201);
  EXPECT_FALSE(bench.memory.explained.has_followed) << "after a sleep of two hours";
}

TEST(Interlocks, QuoteLineThatChamberSentInsteadOfAnswer) {
  auto sample = good_sample();
  sample.chamber.value = failure(FaultKind::timeout, "chamber", "still busy after 900 ms; received \"@04ID=A; B\"");
  EXPECT_EQ(after(sample, 7).cause, "chamber silent for 7 s; received \"@04ID=A; B\"");
  sample.chamber.value = failure(FaultKind::disconnected, "chamber", "no connection");
  EXPECT_EQ(after(sample, 7).cause, "chamber silent for 7 s");
}

TEST(Interlocks, ForgetSilenceThatEnded) {
  auto silent = good_sample();
  silent.chamber.value = no_reply();
  interlocks::InterlockResult result;
  for (int i = 0; i < 300; ++i) result = judge({}, result.memory, silent, kSecond);
  result = judge({}, result.memory, good_sample(), kSecond);
  EXPECT_EQ(result.demand.reaction, interlocks::Reaction::go_on);
  for (int i = 0; i < 4; ++i) result = judge({}, result.memory, silent, kSecond);
  EXPECT_EQ(result.demand.reaction, interlocks::Reaction::go_on) << "the next silence is counted from its own start";
}

TEST(Interlocks, ContinueWithOneThermometer) {
  auto sample = good_sample();
  for (std::size_t i = 1; i < sample.thermometers.size(); ++i) sample.thermometers[i].value = no_reply();
  EXPECT_EQ(after(sample, 1000).reaction, interlocks::Reaction::warn) << "if the analysis needs no other";
  sample.thermometers[0].value = no_reply();
  EXPECT_EQ(after(sample, 1000).reaction, interlocks::Reaction::abort);
}

TEST(Interlocks, AbortAtSecondSampleOutsideLimit) {
  auto sample = good_sample();
  sample.thermometers[3].value = Celsius{100.5};
  EXPECT_EQ(after(sample, 1).reaction, interlocks::Reaction::go_on);
  EXPECT_EQ(after(sample, 2).reaction, interlocks::Reaction::abort);
  EXPECT_EQ(after(sample, 2).cause, "a thermometer reads 100.50 °C, outside -60 … 100 °C");
  sample = good_sample();
  sample.chamber.value->air = {-60.5};
  EXPECT_EQ(after(sample, 2).reaction, interlocks::Reaction::abort);
}

/// Judges the samples in turn, one second each, and returns the last result.
interlocks::InterlockResult evaluate_all(const std::vector<Sample>& samples,
                                         const interlocks::InterlockLimits& limits = {}) {
  interlocks::InterlockResult result;
  for (const auto& sample : samples) result = judge(limits, result.memory, sample, kSecond);
  return result;
}

TEST(Interlocks, DoNotTakeLostReadingAsWithinLimit) {
  const auto good = good_sample();
  auto hot_air = good, hot_uut = good, silent = good, loose = good;
  hot_air.chamber.value->air = {101};
  silent.chamber.value = no_reply();
  EXPECT_EQ(evaluate_all({hot_air, silent, hot_air}).demand.reaction, interlocks::Reaction::abort);
  EXPECT_EQ(evaluate_all({hot_air, good, hot_air}).demand.reaction, interlocks::Reaction::abort) << "2 of the last 4";
  EXPECT_NE(evaluate_all({hot_air, good, good, good, hot_air}).demand.reaction, interlocks::Reaction::abort);
  hot_uut.thermometers[3].value = Celsius{100.5};
  loose.thermometers[3].value = no_reply();
  EXPECT_EQ(evaluate_all({hot_uut, loose, hot_uut}).demand.reaction, interlocks::Reaction::abort);
  std::vector<Sample> long_silence(3600, loose);
  long_silence.front() = long_silence.back() = hot_uut;
  EXPECT_EQ(evaluate_all(long_silence).demand.reaction, interlocks::Reaction::abort)
      << "regardless of the duration of the loss";
  auto other_lost = good;
  other_lost.thermometers[4].value = no_reply();
  EXPECT_NE(evaluate_all({hot_uut, other_lost, other_lost, other_lost, hot_uut}).demand.reaction,
            interlocks::Reaction::abort)
      << "the hot one was read in between";
}

TEST(Interlocks, KeepCauseWithoutReadingUntilSilence) {
  auto open = good_sample(), silent = good_sample();
  open.chamber.value->activity = ChamberActivity::door_open;
  silent.chamber.value = no_reply();
  EXPECT_EQ(evaluate_all({open, silent, silent, silent}).demand.cause, "the chamber's door is open");
  EXPECT_EQ(evaluate_all({open, silent, silent, silent}).demand.reaction, interlocks::Reaction::suspend);
  EXPECT_EQ(evaluate_all({open, silent, good_sample()}).demand.reaction, interlocks::Reaction::go_on);
  std::vector<Sample> lost(20, silent);
  lost.front() = open;
  EXPECT_EQ(evaluate_all(lost).demand.cause, "chamber silent for 19 s");
}

TEST(Interlocks, CauseWithoutReadingDemandsNothingNextToAnother) {
  interlocks::InterlockLimits limits;
  limits.policy[static_cast<std::size_t>(interlocks::InterlockId::door)] = interlocks::Reaction::hold;
  std::vector<Sample> samples(20, good_sample());
  samples.front().chamber.value->activity = ChamberActivity::door_open;
  for (std::size_t i = 1; i < samples.size(); ++i) samples[i].chamber.value = no_reply();
  const auto result = evaluate_all(samples, limits);
  ASSERT_EQ(result.demand.reaction, interlocks::Reaction::suspend);
  EXPECT_EQ(demand_without(result.memory, {interlocks::InterlockId::chamber_silent}).reaction,
            interlocks::Reaction::go_on);
}

TEST(Interlocks, CountTimeBetweenReadings) {
  interlocks::InterlockLimits limits;
  limits.follow_time = std::chrono::seconds(30);
  auto still = good_sample(), silent = good_sample();
  silent.chamber.value = no_reply();
  still.chamber.value->set_point = {60};
  interlocks::InterlockResult result = judge(limits, {}, good_sample(), kSecond);
  int seconds = 0;
  for (; seconds < 1000 && result.demand.reaction < interlocks::Reaction::suspend; ++seconds)
    result = judge(limits, result.memory, seconds % 2 == 0 ? still : silent, kSecond);
  interlocks::InterlockResult each = judge(limits, {}, good_sample(), kSecond);
  int each_seconds = 0;
  for (; each_seconds < 1000 && each.demand.reaction < interlocks::Reaction::suspend; ++each_seconds)
    each = judge(limits, each.memory, still, kSecond);
  ASSERT_LT(each_seconds, 1000);
  EXPECT_NEAR(seconds, each_seconds, 3) << "air that does not follow";
}

TEST(Interlocks, AbortOverdueSegment) {
  auto sample = good_sample();
  sample.progress.phase = Phase::overdue;
  EXPECT_EQ(after(sample, 1).reaction, interlocks::Reaction::abort);
}

TEST(Interlocks, FollowRequestsOfChamber) {
  auto sample = good_sample();
  sample.chamber.value->alarms = {"filter dirty"};
  EXPECT_EQ(after(sample, 100).reaction, interlocks::Reaction::go_on) << "a note does not stop the run";
  sample.chamber.value->activity = ChamberActivity::door_open;
  EXPECT_EQ(after(sample, 1).reaction, interlocks::Reaction::suspend);
  sample.chamber.value->must_stop = true;
  EXPECT_EQ(after(sample, 1).reaction, interlocks::Reaction::abort);
  EXPECT_EQ(after(sample, 1).cause, "chamber alarm: filter dirty");
  sample = good_sample();
  sample.chamber.value->activity = ChamberActivity::emergency_stop;
  EXPECT_EQ(after(sample, 1).reaction, interlocks::Reaction::abort);
}

TEST(Interlocks, ApplyMostSevereReaction) {
  auto sample = good_sample();
  sample.units[0].count.value = no_reply();
  sample.thermometers[0].value = Celsius{150};
  EXPECT_EQ(after(sample, 10).reaction, interlocks::Reaction::abort);
}

/// Returns the row of docs/interlocks.md that begins with the interlock's name; empty if there is none.
std::string documented_row(const std::string& page, const interlocks::Interlock& row) {
  const auto begin = page.find(fmt::format("\n| `{}`{} | {} |", row.name, row.choosable ? "" : " ×", name(row.usual)));
  return begin == std::string::npos ? "" : page.substr(begin + 1, page.find('\n', begin + 1) - begin - 1);
}

TEST(Interlocks, AreDocumentedWithReactionAndLimits) {
  const auto page = read_text_file(GYROTHERM_SOURCE_DIR "/docs/interlocks.md");
  ASSERT_TRUE(page) << text(page.error());
  const auto limits = page->substr(page->find("## `[limits]`"));
  for (std::size_t i = 0; i < interlocks::kInterlocks; ++i) {
    const auto& row = interlock(static_cast<interlocks::InterlockId>(i));
    const auto said = documented_row(*page, row);
    EXPECT_NE(said, "") << row.name << " has no row or a different reaction";
    std::istringstream keys{std::string(row.limits)};
    for (std::string key; keys >> key;) {
      EXPECT_NE(said.find(fmt::format("`{}`", key)), std::string::npos) << row.name << " does not mention " << key;
      EXPECT_NE(limits.find(fmt::format("`{}`", key)), std::string::npos) << key << " has no default";
    }
  }
}

}  // namespace
}  // namespace gyrotherm::run
