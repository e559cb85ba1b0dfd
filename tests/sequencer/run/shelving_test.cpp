// SPDX-License-Identifier: Apache-2.0
/// Operators shelve warnings for a time. The program unshelves them, also after it was late.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

const char* kTwoDays = "[[segment]]\nkind = \"hold\"\nat = \"20 °C\"\ntime = \"48 h\"\n";
const char* kAda = "ada (uid 1000)";

/// A run with three units. Its thermometers and its first unit become silent on command.
class ShelvingRun : public testing::Test {
 protected:
  ShelvingRun() { bench_.seconds(5); }
  void lose_thermometer(bool lost) {
    bench_.instruments().silent_thermometers = lost ? std::vector<std::size_t>{3} : std::vector<std::size_t>{};
    bench_.seconds(20);
  }
  control::ControlAnswer send_request(const std::string& word, const std::string& text) {
    const auto request = control::make_request(word, text);
    EXPECT_TRUE(request) << word << " " << text;
    return bench_.run_controller().carry_out(*request, kAda);
  }
  [[nodiscard]] std::vector<record::Alarm> list() { return bench_.record().alarms().list(); }
  [[nodiscard]] std::size_t announced() { return record::count_unacknowledged(list()); }
  tests::Bench bench_{kTwoDays, [](rig::RigFile& file) {
                        file.units.assign(3, rig::UnitSettings{});
                        for (std::size_t i = 0; i < 3; ++i) {
                          file.units[i].info.name = fmt::format("u{}", i + 1);
                          file.limits.units.push_back({.name = file.units[i].info.name, .continue_when_silent = true});
                        }
                      }};
};

TEST_F(ShelvingRun, AnnouncesAgainWhenTimeIsOverAndCauseIsActive) {
  lose_thermometer(true);
  ASSERT_EQ(announced(), 1u);
  const auto alarm = list()[0];
  ASSERT_EQ(alarm.reaction, "warn") << alarm.text;
  const auto number = std::to_string(alarm.number);
  const auto answer = send_request("shelve", number + " 2 min its lead is being replaced");
  EXPECT_TRUE(answer.done) << answer.text;
  EXPECT_TRUE(answer.text.starts_with("alarm " + number + " is shelved until 20")) << answer.text;
  const auto event = bench_.record().events.back();
  EXPECT_EQ(event.kind, EventKind::command);
  EXPECT_EQ(event.text, "alarm " + number + " shelved for 2 min 00 s by ada (uid 1000): its lead is being replaced");
  EXPECT_EQ(event.about.interlock, alarm.interlock);
  EXPECT_EQ(event.about.channel, alarm.subject);
  EXPECT_EQ(announced(), 0u);
  bench_.seconds(119);
  EXPECT_EQ(announced(), 0u);
  bench_.seconds(1);
  EXPECT_EQ(announced(), 1u) << "exactly after its time";
  EXPECT_EQ(bench_.count(EventKind::command, "alarm " + number + " unshelved: the time is over"), 1);
  EXPECT_EQ(list()[0].number, bench_.record().events.back().number);
  bench_.seconds(300);
  EXPECT_EQ(bench_.count(EventKind::command, "unshelved"), 1) << "once";
}

TEST_F(ShelvingRun, StaysQuietThroughReturnAndRecurrence) {
  lose_thermometer(true);
  const auto number = std::to_string(list()[0].number);
  ASSERT_TRUE(send_request("shelve", number + " 10min chatters").done);
  for (int i = 0; i < 4; ++i) {
    lose_thermometer(false);
    EXPECT_EQ(announced(), 0u);
    lose_thermometer(true);
    EXPECT_EQ(announced(), 0u);
  }
  EXPECT_GE(bench_.count(EventKind::fault, "channel_lost (warn)"), 4) << "the record has every occurrence";
  lose_thermometer(false);
  bench_.seconds(600);
  EXPECT_TRUE(list().empty()) << "it has returned when its time is over";
  EXPECT_EQ(bench_.count(EventKind::command, "unshelved: the time is over"), 1);
  lose_thermometer(true);
  EXPECT_EQ(announced(), 1u);
}

TEST_F(ShelvingRun, EndsByRequestOfOperator) {
  lose_thermometer(true);
  const auto number = std::to_string(list()[0].number);
  EXPECT_FALSE(send_request("unshelve", number).done);
  ASSERT_TRUE(send_request("shelve", number + " 24 h known").done);
  EXPECT_FALSE(send_request("shelve", number + " 1 h once more").done) << "also within the same second";
  const auto answer = send_request("unshelve", number);
  EXPECT_EQ(answer.text, "alarm " + number + " is unshelved; it is active and awaits an acknowledgement");
  EXPECT_EQ(announced(), 1u);
  bench_.seconds(1);
  EXPECT_TRUE(bench_.told(EventKind::command, "ada (uid 1000): unshelve " + number + ", refused: "));
  EXPECT_TRUE(bench_.told(EventKind::command, "ada (uid 1000): shelve " + number + ", refused: alarm "));
  EXPECT_EQ(bench_.count(EventKind::command, "unshelved by ada (uid 1000)"), 1);
  const auto again = std::to_string(list()[0].number);
  ASSERT_TRUE(send_request("shelve", again + " 24 h known").done);
  bench_.seconds(24 * 3600 - 1);
  EXPECT_EQ(announced(), 0u);
  bench_.seconds(1);
  EXPECT_EQ(announced(), 1u) << "after 24 h, the longest time";
}

TEST_F(ShelvingRun, RefusesAlarmsThatSuspendOrAbort) {
  bench_.chamber().door_open = true;
  bench_.seconds(20);
  ASSERT_EQ(list()[0].priority, record::AlarmPriority::medium);
  const auto number = std::to_string(list()[0].number);
  const auto answer = send_request("shelve", number + " 1 h I am at the door");
  EXPECT_FALSE(answer.done);
  EXPECT_NE(answer.text.find("acknowledge it and remove its cause"), std::string::npos) << answer.text;
  EXPECT_FALSE(send_request("shelve", "9999 1 h which").done);
  EXPECT_EQ(announced(), 1u);
  bench_.chamber().must_stop = true;
  bench_.until(RunState::aborting);
  EXPECT_FALSE(send_request("shelve", std::to_string(list()[0].number) + " 1 h the limiter").done);
}

TEST_F(ShelvingRun, ConcernsOneOfSeveralSubjects) {
  bench_.instruments().gyro_silent = true;
  bench_.instruments().silent_thermometers = {3, 5};
  bench_.seconds(20);
  ASSERT_EQ(announced(), 3u);
  const auto rows = list();
  const auto unit = std::ranges::find(rows, "unit_silent", &record::Alarm::interlock);
  ASSERT_NE(unit, rows.end());
  EXPECT_EQ(unit->subject, "u1");
  ASSERT_TRUE(send_request("shelve", std::to_string(unit->number) + " 1 min its cable").done);
  EXPECT_EQ(announced(), 2u);
  EXPECT_EQ(list().back().tag(), "unit_silent u1") << "the shelved ones are the last";
  EXPECT_TRUE(send_request("acknowledge", "all seen").done);
  EXPECT_TRUE(list().back().is_shelved()) << "it is not among all alarms";
  bench_.seconds(60);
  ASSERT_EQ(announced(), 1u);
  EXPECT_EQ(list().front().tag(), "unit_silent u1");
}

/// The machine slept: the end of the shelving was in the gap.
TEST_F(ShelvingRun, EndsInFirstSecondAfterGap) {
  lose_thermometer(true);
  const auto number = std::to_string(list()[0].number);
  ASSERT_TRUE(send_request("shelve", number + " 30 s known").done);
  bench_.late(600);
  bench_.seconds(1);
  EXPECT_EQ(bench_.count(EventKind::command, "alarm " + number + " unshelved: the time is over"), 1);
  EXPECT_GE(announced(), 1u);
}

/// The profile or the policy of a resumed run may give the interlock another reaction.
TEST_F(ShelvingRun, EndsWhenReactionBecomesSevere) {
  lose_thermometer(true);
  const auto row = list()[0];
  ASSERT_TRUE(send_request("shelve", std::to_string(row.number) + " 2 h known").done);
  bench_.run_controller().note(EventKind::interlock, "channel_lost (suspend): no reading",
                               {.interlock = row.interlock, .reaction = "suspend", .channel = row.subject});
  bench_.seconds(1);
  EXPECT_EQ(announced(), 1u);
  EXPECT_EQ(list()[0].priority, record::AlarmPriority::medium);
  EXPECT_EQ(bench_.count(EventKind::command, "unshelved: it is no longer a warning"), 1);
  bench_.seconds(1);
  EXPECT_EQ(bench_.count(EventKind::command, "unshelved"), 1);
}

TEST_F(ShelvingRun, IsRefusedWhenRunIsOver) {
  lose_thermometer(true);
  const auto number = std::to_string(list()[0].number);
  ASSERT_TRUE(send_request("shelve", number + " 2 h known").done);
  ASSERT_TRUE(send_request("stop", "the day is over").done);
  bench_.until(RunState::stopped);
  const auto answer = send_request("unshelve", number);
  EXPECT_FALSE(answer.done);
  EXPECT_TRUE(answer.text.starts_with("the run is over")) << answer.text;
  EXPECT_TRUE(list()[0].is_shelved()) << "the record shows that it was shelved";
}

}  // namespace
}  // namespace gyrotherm::run
