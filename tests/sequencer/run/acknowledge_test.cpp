// SPDX-License-Identifier: Apache-2.0
/// What an interlock did stands until somebody says that they have seen it; who it was is in the record.
#include <gtest/gtest.h>

#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

const char* kTwoHours = "[[segment]]\nkind = \"hold\"\nat = \"20 °C\"\ntime = \"2 h\"\n";

control::ControlRequest acknowledge(const std::string& text) { return *control::request_of("acknowledge", text); }

/// A door that was open for a while.
class DoorTest : public testing::Test {
 protected:
  DoorTest() {
    bench_.seconds(5);
    bench_.chamber().door_open = true;
    bench_.seconds(20);
    bench_.chamber().door_open = false;
    bench_.seconds(60);
  }
  control::ControlAnswer say(const std::string& text) {
    return bench_.run_controller().carry_out(acknowledge(text), "ada (uid 1000)");
  }
  tests::Bench bench_{kTwoHours};
};

TEST_F(DoorTest, AnAlarmThatIsOverStandsUntilItIsAcknowledged) {
  ASSERT_EQ(bench_.record().alarms().standing().size(), 1u);
  const auto alarm = bench_.record().alarms().standing()[0];
  const auto answer = say(std::to_string(alarm.number) + " looked at the cable");
  EXPECT_TRUE(answer.done) << answer.text;
  EXPECT_TRUE(bench_.record().alarms().standing().empty());
  const auto& event = bench_.record().events.back();
  EXPECT_EQ(event.kind, EventKind::acknowledged);
  EXPECT_EQ(event.text,
            "alarm " + std::to_string(alarm.number) + " acknowledged by ada (uid 1000): looked at the cable");
  EXPECT_EQ(event.about.interlock, alarm.interlock);
  EXPECT_EQ(bench_.run_controller().run_state(), RunState::execute);
}

TEST_F(DoorTest, OneThatIsNotThereOrWasAcknowledgedIsRefusedAndThatIsInTheRecord) {
  const auto number = std::to_string(bench_.record().alarms().standing()[0].number);
  EXPECT_FALSE(say("9999 seen").done);
  EXPECT_EQ(bench_.record().alarms().standing().size(), 1u);
  EXPECT_TRUE(say(number + " seen").done);
  const auto again = say(number + " seen");
  EXPECT_FALSE(again.done);
  EXPECT_EQ(again.text, "alarm " + number + " is acknowledged already") << "also within the same second";
  EXPECT_FALSE(say("all seen").done);
  bench_.seconds(1);
  EXPECT_TRUE(bench_.told(EventKind::command, "ada (uid 1000): acknowledge 9999, refused: there is no alarm 9999"));
  EXPECT_TRUE(bench_.told(EventKind::command, "acknowledge all, refused: no alarm stands"));
}

TEST_F(DoorTest, AllOfThemAreAcknowledgedEachByAnEventOfItsOwn) {
  bench_.chamber().door_open = true;
  bench_.seconds(20);
  ASSERT_EQ(bench_.record().alarms().standing().size(), 2u);
  EXPECT_TRUE(say("all seen").done);
  EXPECT_EQ(bench_.count(EventKind::acknowledged, "acknowledged by ada (uid 1000): seen"), 2);
  EXPECT_TRUE(bench_.record().alarms().standing().empty());
}

TEST_F(DoorTest, WhoWasToldIsInTheRecord) {
  const auto request = *control::request_of("told", "anna@lab.example: rule night, alarm 7");
  EXPECT_TRUE(bench_.run_controller().carry_out(request, "gyrotherm-monitor (uid 998)").done);
  bench_.seconds(1);
  EXPECT_TRUE(bench_.told(EventKind::told, "gyrotherm-monitor (uid 998): anna@lab.example: rule night, alarm 7"));
}

}  // namespace
}  // namespace gyrotherm::run
