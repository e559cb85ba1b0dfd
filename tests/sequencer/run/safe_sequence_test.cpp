// SPDX-License-Identifier: Apache-2.0
/// Runs that end by making the chamber safe, and chambers that acknowledge it and continue to heat.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/file.hpp"
#include "sequencer/run/chamber_lead.hpp"
#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

const std::string kHoldAt30 = "[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"2 h\"\n";
constexpr Kelvins kTolerance{0.1};

/// Sets a chamber with states, start and stop. Its air is watched for five minutes.
void watch_air(rig::RigFile& file) {
  const auto name = GYROTHERM_SOURCE_DIR "/profiles/chambers/watlow_f4t.toml";
  file.chamber_map = drivers::parse_register_map(read_text_file(name).value(), name).value();
  file.safe_observe = std::chrono::minutes(5);
}

/// Aborts a run at 30 °C, as an operator.
void abort_at_30(tests::Bench& bench) {
  bench.chamber().air_c = 30;
  bench.seconds(60);
  bench.run_controller().submit(OperatorCommand::abort, "Ada");
  bench.seconds(1);
  ASSERT_EQ(bench.run_controller().run_state(), RunState::aborting);
}

TEST(SafeSequence, WatchesAirBeforeRunEnds) {
  tests::Bench bench(kHoldAt30, watch_air);
  abort_at_30(bench);
  EXPECT_EQ(bench.seconds(290), RunOutcome::going_on);
  EXPECT_EQ(bench.seconds(30), RunOutcome::made_safe);
  const auto cause = bench.run_controller().end_cause();
  for (const auto* part : {"the chamber was sent to 20 °C (set point read back; mode running; air 20.", "near 20 °C"})
    EXPECT_NE(cause.find(part), std::string::npos) << part << " in " << cause;
  EXPECT_TRUE(bench.instruments().switched.empty()) << "the mode was right";
}

TEST(SafeSequence, ReportsChamberThatCannotBeReadAtOnceAndThenOnceAMinute) {
  tests::Bench bench(kHoldAt30, watch_air);
  abort_at_30(bench);
  bench.seconds(2);
  bench.chamber().silent = true;
  const std::string words = "is NOT confirmed safe yet";
  EXPECT_EQ(bench.seconds(10), RunOutcome::going_on);
  EXPECT_EQ(bench.count(EventKind::fault, words), 1);
  EXPECT_EQ(bench.count(EventKind::fault, "no reply in 500 ms); further attempts follow"), 1) << "with the reason";
  bench.seconds(50);
  EXPECT_EQ(bench.count(EventKind::fault, words), 1);
  bench.seconds(70);
  EXPECT_EQ(bench.count(EventKind::fault, words), 3);
  bench.chamber().silent = false;
  EXPECT_EQ(bench.seconds(600), RunOutcome::made_safe);
  EXPECT_EQ(bench.run_controller().end_cause().find("no reading"), std::string::npos);
}

TEST(SafeSequence, ReportsRefusedSetPointAndSwitchesOff) {
  tests::Bench bench(kHoldAt30, watch_air);
  bench.chamber().air_c = bench.chamber().set_point_c = 30;
  bench.seconds(60);
  bench.chamber().refuses = true;
  bench.run_controller().submit(OperatorCommand::abort, "Ada");
  bench.seconds(3);
  const auto faults = bench.run_controller().overview().faults_now;
  ASSERT_FALSE(faults.empty());
  EXPECT_NE(faults.back().find("the chamber could NOT be sent to 20 °C"), std::string::npos) << faults.back();
  bench.seconds(75);
  EXPECT_EQ(bench.count(EventKind::interlock, "safe_ineffective (abort): "), 1) << "after a minute";
  EXPECT_FALSE(bench.chamber().on) << "the chamber obeys this command";
}

TEST(SafeSequence, WritesModeOfChamberInManualMode) {
  tests::Bench bench(kHoldAt30, watch_air);
  abort_at_30(bench);
  bench.chamber().manual = true;
  EXPECT_EQ(bench.seconds(1000), RunOutcome::made_safe);
  EXPECT_FALSE(bench.chamber().manual);
  EXPECT_EQ(bench.instruments().switched, std::vector<bool>{true});
  EXPECT_LT(bench.chamber().air_c, 22);
}

TEST(SafeSequence, SwitchesOffChamberThatContinuesToHeatAndRaisesAlarm) {
  for (const bool hides_mode : {false, true}) {
    tests::Bench bench(kHoldAt30, watch_air);
    abort_at_30(bench);
    bench.chamber().manual = bench.chamber().keeps_manual = true;
    bench.chamber().hides_mode = hides_mode;
    int highest = 0;
    for (int s = 0; s < 250; ++s) {
      EXPECT_EQ(bench.seconds(1), RunOutcome::going_on) << "no run ends while the air moves away";
      highest = std::max(highest, static_cast<int>(bench.chamber().air_c));
    }
    EXPECT_LT(highest, 50);
    EXPECT_FALSE(bench.chamber().on);
    EXPECT_EQ(bench.count(EventKind::interlock, "safe_ineffective (abort): "), 1);
    bench.chamber().hides_mode = false;
    EXPECT_EQ(bench.seconds(600), RunOutcome::made_safe);
    const auto cause = bench.run_controller().end_cause();
    EXPECT_NE(cause.find("sent to 20 °C and switched off (set point read back; mode off; air "), std::string::npos)
        << cause;
  }
}

TEST(SafeSequence, SwitchesOffAgainWhenChamberStartsAgain) {
  tests::Bench bench(kHoldAt30, [](rig::RigFile& file) {
    watch_air(file);
    file.safe_off = true;
  });
  abort_at_30(bench);
  ASSERT_FALSE(bench.chamber().on);
  for (int i = 0; i < 3; ++i) {
    bench.seconds(100);
    bench.chamber().on = true;
    EXPECT_EQ(bench.seconds(20), RunOutcome::going_on);
    EXPECT_FALSE(bench.chamber().on) << "within ten seconds";
  }
  EXPECT_EQ(bench.seconds(320), RunOutcome::made_safe);
}

TEST(SafeSequence, ReportsNoSwitchOffThatFailed) {
  tests::Bench bench(kHoldAt30, [](rig::RigFile& file) {
    watch_air(file);
    file.safe_off = true;
  });
  bench.chamber().refuses_off = true;
  abort_at_30(bench);
  for (int s = 0; s < 130; ++s) {
    EXPECT_EQ(bench.seconds(1), RunOutcome::going_on);
    EXPECT_EQ(bench.run_controller().end_cause().find("and switched off"), std::string::npos)
        << s << ": " << bench.run_controller().end_cause();
  }
  EXPECT_GE(
      bench.count(EventKind::fault, "sent to 20 °C, but could NOT be switched off (chamber stop: no such command"), 2)
      << "once a minute";
  bench.chamber().refuses_off = false;
  EXPECT_EQ(bench.seconds(600), RunOutcome::made_safe);
  EXPECT_NE(bench.run_controller().end_cause().find("sent to 20 °C and switched off ("), std::string::npos)
      << bench.run_controller().end_cause();
}

TEST(SafeSequence, WatchesAirAfterStop) {
  tests::Bench bench(kHoldAt30, watch_air);
  bench.chamber().air_c = 30;
  bench.seconds(60);
  bench.run_controller().submit(OperatorCommand::stop, "Ada");
  bench.seconds(1);
  bench.chamber().manual = bench.chamber().keeps_manual = true;
  EXPECT_EQ(bench.seconds(300), RunOutcome::going_on);
  EXPECT_EQ(bench.seconds(600), RunOutcome::stopped);
  EXPECT_FALSE(bench.chamber().on);
}

TEST(SafeSequence, LeavesAirToGuardWithoutTicks) {
  tests::Bench bench(kHoldAt30, watch_air);
  bench.seconds(60);
  bench.run_controller().make_safe("the disk is full");
  EXPECT_EQ(bench.chamber().set_point_c, 20);
  EXPECT_FALSE(bench.run_controller().is_safe()) << "the guard still watches";
  EXPECT_NE(bench.run_controller().end_cause().find("was sent to 20 °C, and is NOT confirmed safe yet"),
            std::string::npos)
      << bench.run_controller().end_cause();
}

TEST(NotFollowing, SuspendsUntilModeReturnsOrOperatorTakesOver) {
  tests::Bench bench(kHoldAt30, watch_air);
  bench.seconds(60);
  bench.chamber().manual = bench.chamber().keeps_manual = true;
  bench.seconds(2);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::suspended);
  EXPECT_TRUE(bench.told(EventKind::interlock, "not_following (suspend): "));
  const auto sent = bench.chamber().sent_c.size();
  bench.seconds(20);
  EXPECT_EQ(bench.chamber().sent_c.size(), sent) << "a foreign set point is not overwritten";
  EXPECT_TRUE(bench.instruments().switched.empty());
  EXPECT_NE(bench.run_controller().describe_external_change(), "");
  bench.chamber().keeps_manual = false;
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  bench.seconds(2);
  EXPECT_FALSE(bench.chamber().manual);
  EXPECT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_EQ(bench.run_controller().describe_external_change(), "");
}

TEST(NotFollowing, PreventsStopFromLeavingChamber) {
  for (const bool manual : {true, false}) {
    tests::Bench bench(kHoldAt30, [](rig::RigFile& file) {
      watch_air(file);
      file.run_limits.on_stop = interlocks::OnStop::hold;
    });
    bench.seconds(60);
    bench.chamber().manual = manual;
    if (!manual) bench.chamber().set_point_c = 55;
    bench.seconds(2);
    bench.run_controller().submit(OperatorCommand::stop, "Ada");
    bench.seconds(1);
    EXPECT_EQ(bench.run_controller().run_state(), RunState::aborting);
    EXPECT_TRUE(bench.told(EventKind::fault, "another program or its panel changed its set point"));
    EXPECT_EQ(bench.seconds(2000), RunOutcome::stopped);
    EXPECT_EQ(bench.chamber().set_point_c, 20);
  }
}

/// A program whose last segment is a hold at 30 °C. It is observed for `count` seconds with the chamber in one
/// activity.
class LastSegment {
 public:
  interlocks::InterlockInputs after(int count, ChamberActivity activity, double air, double rises = 0) {
    interlocks::InterlockInputs inputs;
    for (int i = 0; i < count; ++i) {
      air_ = air + rises * i;
      sample_.chamber = {ChamberState{{air_}, {30}, activity}, {}};
      lead_.fill_inputs(second(), inputs);
    }
    return inputs;
  }
  [[nodiscard]] std::string objection() const { return lead_.incomplete_reason(second()); }

 private:
  [[nodiscard]] LeadSecond second() const {
    return {.sample = sample_,
            .goal = {30},
            .at = kSecond * ++at_,
            .in_last_segment = true,
            .in_last_hold = true,
            .end = {30}};
  }
  mutable std::int64_t at_ = 0;
  double air_{};
  Sample sample_;
  ControllerLead lead_{kTolerance};
};

TEST(LastSegment, EndsWhenControllerHoldsItsSetPoint) {
  for (const auto activity : {ChamberActivity::program, ChamberActivity::soaking, ChamberActivity::running,
                              ChamberActivity::done, ChamberActivity::unknown}) {
    LastSegment last;
    EXPECT_EQ(last.after(200, activity, 30).program, "") << name(activity);
    EXPECT_EQ(last.objection(), "") << name(activity);
  }
}

TEST(LastSegment, IsMonitoredLikeOtherSegments) {
  for (const auto activity :
       {ChamberActivity::not_following, ChamberActivity::holding, ChamberActivity::alarm, ChamberActivity::off}) {
    LastSegment last;
    EXPECT_EQ(last.after(37, activity, 30).program, "");
    EXPECT_EQ(last.objection().empty(), activity == ChamberActivity::off) << name(activity);
    EXPECT_NE(last.after(30, activity, 30).program, "") << name(activity) << ": for more than a minute";
  }
  LastSegment heats;
  EXPECT_NE(heats.after(90, ChamberActivity::running, 30, 0.5).program, "") << "the mode is right, the air is not";
  EXPECT_NE(heats.objection().find("the air moves away from 30 °C"), std::string::npos) << heats.objection();
}

TEST(LastSegment, MakesChamberSafeWhenNotFollowedAtEnd) {
  tests::Bench bench("[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"1 min\"\n", watch_air);
  bench.chamber().air_c = bench.chamber().set_point_c = 30;
  bench.run_controller().hand_over_to_controller();
  bench.seconds(20);
  bench.chamber().manual = true;
  EXPECT_EQ(bench.seconds(1000), RunOutcome::made_safe);
  EXPECT_NE(bench.run_controller().end_cause().find("at the end of its program"), std::string::npos)
      << bench.run_controller().end_cause();
  EXPECT_TRUE(bench.told(EventKind::fault, "not_following") || bench.told(EventKind::interlock, "not_following"));
  EXPECT_EQ(bench.chamber().set_point_c, 20);
  EXPECT_FALSE(bench.chamber().manual);
}

}  // namespace
}  // namespace gyrotherm::run
