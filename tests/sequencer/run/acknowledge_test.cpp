// SPDX-License-Identifier: Apache-2.0
/// Operators acknowledge alarms: one, several or all. The record has the operator and the comment.
#include <gtest/gtest.h>

#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

const char* kTwoHours = "[[segment]]\nkind = \"hold\"\nat = \"20 °C\"\ntime = \"2 h\"\n";

control::ControlRequest acknowledge(const std::string& text) { return *control::make_request("acknowledge", text); }

/// A run after its door was open for a while.
class DoorTest : public testing::Test {
 protected:
  DoorTest() {
    bench_.seconds(5);
    open_door();
  }
  void open_door() {
    bench_.chamber().door_open = true;
    bench_.seconds(20);
    bench_.chamber().door_open = false;
    bench_.seconds(60);
  }
  control::ControlAnswer send_request(const std::string& text) {
    return bench_.run_controller().carry_out(acknowledge(text), "ada (uid 1000)");
  }
  [[nodiscard]] std::vector<record::Alarm> list() { return bench_.record().alarms().list(); }
  tests::Bench bench_{kTwoHours};
};

TEST_F(DoorTest, KeepsClearedAlarmUntilAcknowledged) {
  ASSERT_EQ(list().size(), 1u);
  const auto alarm = list()[0];
  EXPECT_EQ(describe_alarm_state(alarm), "returned");
  const auto answer = send_request(std::to_string(alarm.number) + " looked at the cable");
  EXPECT_TRUE(answer.done) << answer.text;
  EXPECT_TRUE(list().empty());
  const auto& event = bench_.record().events.back();
  EXPECT_EQ(event.kind, EventKind::acknowledged);
  EXPECT_EQ(event.text,
            "alarm " + std::to_string(alarm.number) + " acknowledged by ada (uid 1000): looked at the cable");
  EXPECT_EQ(event.about.interlock, alarm.interlock);
  EXPECT_EQ(bench_.run_controller().run_state(), RunState::execute);
}

TEST_F(DoorTest, RefusesAndRecordsAcknowledgementOfUnknownAlarm) {
  const auto number = std::to_string(list()[0].number);
  EXPECT_FALSE(send_request("9999 seen").done);
  EXPECT_EQ(list().size(), 1u);
  EXPECT_TRUE(send_request(number + " seen").done);
  const auto again = send_request(number + " seen");
  EXPECT_FALSE(again.done);
  EXPECT_EQ(again.text, "alarm " + number + " is acknowledged already") << "also within the same second";
  EXPECT_FALSE(send_request("all seen").done);
  bench_.seconds(1);
  EXPECT_TRUE(bench_.told(EventKind::command, "ada (uid 1000): acknowledge 9999, refused: there is no alarm 9999"));
  EXPECT_TRUE(bench_.told(EventKind::command, "acknowledge all, refused: all alarms are acknowledged"));
}

TEST_F(DoorTest, AcknowledgesAllOccurrencesOfOneCauseOnce) {
  const auto number = list()[0].number;
  for (int i = 0; i < 4; ++i) open_door();
  ASSERT_EQ(list().size(), 1u);
  EXPECT_EQ(list()[0].count, 5);
  EXPECT_EQ(list()[0].number, number) << "a comment typed meanwhile still applies to the row";
  EXPECT_TRUE(send_request(std::to_string(number) + " the latch").done);
  EXPECT_EQ(bench_.count(EventKind::acknowledged, "acknowledged by ada (uid 1000): the latch"), 1);
  EXPECT_TRUE(list().empty());
  EXPECT_EQ(bench_.count(EventKind::interlock, "door (suspend)"), 5) << "the record has every occurrence";
}

/// A door, a gyro and a refusing chamber: three causes, acknowledged in three ways.
TEST_F(DoorTest, AcknowledgesOneSeveralOrAllAlarms) {
  for (const auto* how : {"one by one", "several", "all"}) {
    bench_.chamber().door_open = true;
    bench_.instruments().gyro_silent = true;
    bench_.seconds(20);
    bench_.chamber().door_open = false;
    bench_.instruments().gyro_silent = false;
    bench_.seconds(30);
    const auto rows = list();
    ASSERT_EQ(record::count_unacknowledged(rows), 2u) << how;
    const auto a = std::to_string(rows[0].number), b = std::to_string(rows[1].number);
    if (how == std::string("one by one")) {
      EXPECT_EQ(send_request(a + " first").text, "1 alarm is acknowledged");
      EXPECT_EQ(record::count_unacknowledged(list()), 1u);
      EXPECT_TRUE(send_request(b + " second").done);
    } else if (how == std::string("several")) {
      EXPECT_EQ(send_request(a + "," + b + ",9999 both").text.substr(0, 49),
                "2 alarms are acknowledged; there is no alarm 9999");
    } else {
      EXPECT_EQ(send_request("all seen").text, "2 alarms are acknowledged");
    }
    EXPECT_TRUE(list().empty()) << how;
  }
}

TEST_F(DoorTest, KeepsAcknowledgedAlarmUntilCleared) {
  bench_.chamber().door_open = true;
  bench_.seconds(20);
  EXPECT_TRUE(send_request("all I am at the door").done);
  ASSERT_EQ(list().size(), 1u);
  EXPECT_EQ(describe_alarm_state(list()[0]), "active, acknowledged");
  EXPECT_EQ(list()[0].comment, "I am at the door");
  EXPECT_EQ(list()[0].acknowledged_by, "ada (uid 1000)");
  bench_.chamber().door_open = false;
  bench_.seconds(20);
  EXPECT_TRUE(list().empty());
}

TEST_F(DoorTest, RecordsNotifiedUsers) {
  const auto request = *control::make_request("told", "anna@lab.example: rule night, alarm 7");
  EXPECT_TRUE(bench_.run_controller().carry_out(request, "gyrotherm-monitor (uid 998)").done);
  bench_.seconds(1);
  EXPECT_TRUE(bench_.told(EventKind::told, "gyrotherm-monitor (uid 998): anna@lab.example: rule night, alarm 7"));
}

TEST_F(DoorTest, RecordsReasonForEnd) {
  for (const auto* word : {"stop", "abort"}) {
    tests::Bench bench(kTwoHours);
    bench.seconds(5);
    EXPECT_TRUE(
        bench.run_controller().carry_out(*control::make_request(word, "the coolant is low"), "ada (uid 1000)").done);
    bench.seconds(1);
    EXPECT_TRUE(bench.told(EventKind::command, std::string(word) + " by ada (uid 1000): the coolant is low"));
    EXPECT_NE(bench.run_controller().end_cause().find("by ada (uid 1000): the coolant is low"), std::string::npos)
        << bench.run_controller().end_cause();
  }
}

}  // namespace
}  // namespace gyrotherm::run
