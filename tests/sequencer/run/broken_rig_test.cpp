// SPDX-License-Identifier: Apache-2.0
/// Runs on a rig in which one thing breaks. Tests the commands sent, the waits, and the end of the run.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

/// Two minutes at 20 °C, a ramp to 30 °C at 5 °C/min, a soak of ten minutes there, and back.
const std::string kSoak = R"([[segment]]
kind = "hold"
at = 20
time = "2 min"
[[segment]]
kind = "ramp"
to = 30
rate = 5
[[segment]]
kind = "hold"
time = "10 min"
guaranteed_soak = true
soak_band = 1
[[segment]]
kind = "ramp"
to = 20
rate = 5
)";

/// Returns the greatest difference between a set point sent and the previous one.
double largest_set_point_step(const std::vector<double>& sent, std::size_t from = 0) {
  double greatest = 0;
  for (auto i = std::max<std::size_t>(from, 1); i < sent.size(); ++i)
    greatest = std::max(greatest, std::abs(sent[i] - sent[i - 1]));
  return greatest;
}

TEST(BrokenRig, RaisesNoAlarmAndWaitsNotWithoutFault) {
  tests::Bench bench(kSoak);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  for (const auto& sample : bench.record().samples)
    ASSERT_TRUE(sample.state == RunState::execute || sample.state == RunState::complete) << sample.slot;
  EXPECT_EQ(bench.count(EventKind::interlock, ""), 0);
  EXPECT_LE(largest_set_point_step(bench.chamber().sent_c), 5.0 / 60 + 1e-6);
}

TEST(BrokenRig, OpenDoorStopsClockAndShortensNoSoak) {
  tests::Bench bench(kSoak);
  bench.seconds(400);
  const auto before = bench.progress();
  ASSERT_EQ(before.segment, 2);
  bench.chamber().door_open = true;
  bench.seconds(60);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::suspended);
  EXPECT_EQ(bench.run_controller().overview().cause, "the chamber's door is open");
  EXPECT_EQ(bench.progress(), before);
  EXPECT_EQ(bench.run_controller().overview().faults_now.size(), 1u);
  bench.chamber().door_open = false;
  EXPECT_EQ(bench.until(RunState::execute, 100), 10);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  EXPECT_GE(bench.run_controller().overview().behind_plan, std::chrono::seconds(69));
  int soaked = 0;
  for (const auto& sample : bench.record().samples)
    soaked += sample.state == RunState::execute && sample.progress.segment == 2 &&
              std::abs(sample.chamber.value->air.value - 30) <= 1;
  EXPECT_GE(soaked, 600);
}

TEST(BrokenRig, NamesChamberInFaultOfSetPoint) {
  for (const std::string place : {"modbus 10.0.0.5:502 unit 1 write 288+1", "", "chamber", "chamber write"}) {
    tests::Bench bench(kSoak);
    bench.seconds(200);
    bench.chamber().fault_place = place;
    bench.chamber().refuses = true;
    bench.seconds(20);
    bench.chamber().refuses = false;
    bench.seconds(20);
    const auto& events = bench.record().events;
    const auto fault = std::ranges::find_if(events, [](const auto& event) {
      return event.kind == EventKind::fault && event.text.ends_with(": exception 4");
    });
    ASSERT_NE(fault, events.end()) << place;
    EXPECT_TRUE(fault->text.starts_with("chamber")) << fault->text;
    EXPECT_EQ(fault->text.find("chamber: chamber"), std::string::npos) << fault->text;
    EXPECT_NE(fault->text.find(place), std::string::npos) << fault->text;
  }
}

TEST(BrokenRig, RampsRestartedChamberBackFromAir) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.chamber().silent = true;
  bench.seconds(20);
  bench.chamber().silent = false;
  bench.chamber().restart();
  for (int i = 0; i < 60; ++i) bench.chamber().second();  // the air drifts meanwhile
  const auto sent = bench.chamber().sent_c.size();
  const double air = bench.chamber().air_c;
  ASSERT_LT(air, 27);
  bench.seconds(2);
  ASSERT_GT(bench.chamber().sent_c.size(), sent);
  EXPECT_NEAR(bench.chamber().sent_c[sent], air, 0.5);
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_LE(largest_set_point_step(bench.chamber().sent_c, sent + 1), 6.0 / 60 * 12) << "no jump";
  EXPECT_NEAR(bench.chamber().air_c, 30, 2);
  EXPECT_EQ(bench.count(EventKind::interlock, "restarted"), 1);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
}

/// Disconnects the chamber from the mains for 20 s, and lets 2 s pass.
void interrupt_mains(tests::Bench& bench, bool keeps_its_set_point) {
  bench.seconds(500);
  bench.chamber().silent = true;
  bench.seconds(20);
  bench.chamber().silent = false;
  bench.chamber().on = false;
  if (!keeps_its_set_point) bench.chamber().restart();
  bench.seconds(2);
}

TEST(BrokenRig, OnlyOperatorSwitchesOnChamberThatReturnsOff) {
  for (const bool keeps_its_set_point : {true, false}) {
    tests::Bench bench(kSoak);
    interrupt_mains(bench, keeps_its_set_point);
    EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
    EXPECT_EQ(bench.count(EventKind::interlock, "restarted_off (hold)"), 1);
    const auto sent = bench.chamber().sent_c.size();
    bench.seconds(3600);
    EXPECT_FALSE(bench.chamber().on) << "someone may reach into the chamber";
    EXPECT_EQ(bench.chamber().sent_c.size(), sent);
    ASSERT_EQ(bench.run_controller().refusal_reason(OperatorCommand::resume), "");
    const double air = bench.chamber().air_c;
    bench.run_controller().submit(OperatorCommand::resume, "Ada");
    bench.seconds(1);
    EXPECT_TRUE(bench.chamber().on);
    ASSERT_GT(bench.chamber().sent_c.size(), sent);
    EXPECT_NEAR(bench.chamber().sent_c[sent], air, 0.5) << "no jump";
    ASSERT_NE(bench.until(RunState::execute, 2000), -1);
    EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  }
}

TEST(BrokenRig, SwitchesOnChamberThatReturnsOffWhenPolicyAllows) {
  const auto suspends = [](rig::RigFile& file) {
    file.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::restarted_off)] =
        interlocks::Reaction::suspend;
  };
  tests::Bench bench(kSoak, suspends);
  interrupt_mains(bench, true);
  EXPECT_TRUE(bench.chamber().on);
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
}

TEST(BrokenRig, WaitsForOperatorAfterRestartWhenPolicyIsHold) {
  const auto holds = [](rig::RigFile& file) {
    file.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::restarted)] = interlocks::Reaction::hold;
  };
  tests::Bench bench(kSoak, holds);
  bench.seconds(500);
  bench.chamber().silent = true;
  bench.seconds(20);
  bench.chamber().silent = false;
  bench.chamber().restart();
  const auto sent = bench.chamber().sent_c.size();
  bench.seconds(600);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
  EXPECT_EQ(bench.chamber().sent_c.size(), sent);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_EQ(bench.chamber().set_point_c, 30);
}

TEST(BrokenRig, OtherInstrumentHoldsRunUntilFirstReturnsAndOperatorResumes) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.instruments().others = {"chamber: another instrument, or other settings: F4T 222; the run began with: F4T 111"};
  bench.chamber().silent = true;
  bench.seconds(3);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
  EXPECT_EQ(bench.count(EventKind::interlock, "F4T 222; the run began with: F4T 111"), 1) << "names both";
  EXPECT_NE(bench.run_controller().refusal_reason(OperatorCommand::resume), "") << "not while it answers";
  bench.instruments().others.clear();
  bench.chamber().silent = false;
  bench.seconds(60);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
}

TEST(BrokenRig, DoesNotOverwriteForeignSetPoint) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.chamber().set_point_c = 40;
  const auto sent = bench.chamber().sent_c.size();
  EXPECT_LE(bench.until(RunState::suspended, 10), 2);
  bench.seconds(600);
  EXPECT_EQ(bench.chamber().sent_c.size(), sent);
  EXPECT_EQ(bench.count(EventKind::interlock, "changed by another program"), 1);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_GT(bench.chamber().sent_c.size(), sent);
  EXPECT_EQ(bench.chamber().set_point_c, 30);
  EXPECT_TRUE(bench.told(EventKind::command, "resume by Ada"));
}

TEST(BrokenRig, DoesNotOverwriteForeignSetPointOnRamp) {
  tests::Bench bench(kSoak);
  bench.seconds(150);
  bench.chamber().set_point_c = 40;
  const auto sent = bench.chamber().sent_c.size();
  EXPECT_LE(bench.until(RunState::suspended, 10), 2);
  bench.seconds(60);
  EXPECT_EQ(bench.chamber().sent_c.size(), sent);
  EXPECT_EQ(bench.chamber().set_point_c, 40);
}

TEST(BrokenRig, ForgetsForeignSetPointThatIsReset) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.chamber().set_point_c = 31;
  bench.seconds(20);
  bench.chamber().set_point_c = 30;
  EXPECT_NE(bench.until(RunState::execute, 20), -1);
}

TEST(BrokenRig, ClockWaitsForAirAfterForeignSetPointIsReset) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.chamber().set_point_c = 60;
  bench.seconds(100);
  bench.chamber().set_point_c = 30;
  ASSERT_GT(bench.chamber().air_c, 50);
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_NEAR(bench.chamber().air_c, 30, 2);
}

/// A refused set point is sent again only while the run continues.
TEST(BrokenRig, DetectsForeignSetPointAfterRefusedOne) {
  tests::Bench bench(kSoak);
  bench.seconds(150);
  bench.chamber().refuses = true;
  bench.seconds(1);
  bench.chamber().refuses = false;
  bench.run_controller().submit(OperatorCommand::pause, "Ada");
  bench.seconds(3);
  ASSERT_EQ(bench.run_controller().run_state(), RunState::held);
  bench.chamber().set_point_c = 45;
  bench.seconds(60);
  EXPECT_EQ(bench.count(EventKind::interlock, "changed by another program"), 1);
  const auto sent = bench.chamber().sent_c.size();
  const double air = bench.chamber().air_c;
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  bench.seconds(1);
  ASSERT_GT(bench.chamber().sent_c.size(), sent);
  EXPECT_NEAR(bench.chamber().sent_c[sent], air, 1) << "starting at the air temperature";
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_LE(largest_set_point_step(bench.chamber().sent_c, sent + 1), 6.0 / 60 * 5 + 1e-6);
}

TEST(BrokenRig, OperatorResumesImmediatelyAfterForeignSetPoint) {
  tests::Bench bench(kSoak, [](rig::RigFile& file) {
    file.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::foreign_set_point)] =
        interlocks::Reaction::hold;
  });
  bench.seconds(500);
  bench.chamber().set_point_c = 40;
  bench.seconds(60);
  ASSERT_EQ(bench.run_controller().run_state(), RunState::held);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  ASSERT_NE(bench.until(RunState::execute, 2000), -1) << "asked once";
  EXPECT_EQ(bench.chamber().set_point_c, 30);
  EXPECT_NEAR(bench.chamber().air_c, 30, 2);
}

/// An operator who resumes a paused run with the panel's set point does not know yet that the machine slept.
TEST(BrokenRig, TakingOverChamberEndsNoOtherHold) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.chamber().set_point_c = 40;
  bench.seconds(30);
  ASSERT_EQ(bench.run_controller().run_state(), RunState::suspended);
  bench.run_controller().submit(OperatorCommand::pause, "Ada");
  bench.seconds(10);
  ASSERT_EQ(bench.run_controller().refusal_reason(OperatorCommand::resume), "");
  bench.late(200);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  bench.seconds(1);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
  EXPECT_EQ(bench.chamber().set_point_c, 40) << "and it is not accepted";
  EXPECT_TRUE(bench.told(EventKind::note,
                         "resume is not carried out: the cause of the hold is still active: the program did not run"));
  bench.seconds(1);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_EQ(bench.chamber().set_point_c, 30);
}

/// Pauses a run, changes the set point at the panel, and resumes the run before the change is reported.
void resume_before_report(tests::Bench& bench) {
  bench.seconds(500);
  bench.run_controller().submit(OperatorCommand::pause, "Ada");
  bench.seconds(10);
  bench.chamber().set_point_c = 40;
  bench.seconds(1);  // perhaps a misreading
  ASSERT_EQ(bench.run_controller().refusal_reason(OperatorCommand::resume), "");
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  bench.seconds(30);
  EXPECT_EQ(bench.chamber().set_point_c, 40);
}

TEST(BrokenRig, ResumeDoesNotTakeOverUnreportedForeignSetPoint) {
  tests::Bench bench(kSoak);
  resume_before_report(bench);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::suspended);
  tests::Bench holding(kSoak, [](rig::RigFile& file) {
    file.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::foreign_set_point)] =
        interlocks::Reaction::hold;
  });
  resume_before_report(holding);
  EXPECT_EQ(holding.run_controller().run_state(), RunState::held);
  EXPECT_TRUE(holding.told(
      EventKind::note, "resume is not carried out: the cause of the hold is still active: changed by another program"));
  for (auto* either : {&bench, &holding}) {
    either->run_controller().submit(OperatorCommand::resume, "Ada");
    ASSERT_NE(either->until(RunState::execute, 2000), -1);
    EXPECT_EQ(either->chamber().set_point_c, 30);
  }
}

TEST(BrokenRig, ResumeReportsRemainingCauses) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  const auto answer_to = [&](const std::string& word) {
    return bench.run_controller().carry_out(control::make_request(word, "").value(), "Ada").text;
  };
  (void)answer_to("pause");
  bench.chamber().set_point_c = 40;
  bench.chamber().door_open = true;
  bench.seconds(10);
  EXPECT_EQ(answer_to("resume"), "continues once this is over: the chamber's door is open");
  bench.seconds(1);
  EXPECT_EQ(answer_to("pause"), "held: the profile's clock and the set point stay unchanged until resume");
  bench.chamber().door_open = false;
  bench.seconds(10);
  EXPECT_EQ(answer_to("resume"), "continues");
}

TEST(BrokenRig, SuspendsWithinThreeSecondsWhenSetPointIsNotApplied) {
  tests::Bench bench(kSoak);
  bench.seconds(130);  // on the ramp
  bench.chamber().ignores = true;
  const auto found = bench.until(RunState::suspended, 20);
  EXPECT_GT(found, 1);
  EXPECT_LE(found, 4);
  EXPECT_TRUE(bench.told(EventKind::interlock, "refuses set points"));
  EXPECT_GE(bench.run_controller().overview().missed_set_points, 3);
  bench.seconds(30);
  bench.chamber().ignores = false;
  ASSERT_NE(bench.until(RunState::execute, 60), -1) << "it is retried";
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
}

TEST(BrokenRig, EndsRunWhenChamberConfirmsSafeStateAfterLimitOfUnit) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.instruments().uut_c = 101;
  EXPECT_EQ(bench.until(RunState::aborting, 10), 2);
  EXPECT_EQ(bench.chamber().set_point_c, 20) << "sent in the same second";
  EXPECT_EQ(bench.chamber().immediate_set_points, 1);
  EXPECT_FALSE(bench.run_controller().is_safe());
  EXPECT_EQ(bench.seconds(1), RunOutcome::made_safe);
  EXPECT_TRUE(bench.run_controller().is_safe());
  EXPECT_EQ(bench.record().samples.back().state, RunState::aborted);
  EXPECT_EQ(bench.record().samples.back().chamber.value->set_point, Celsius{20});
  EXPECT_NE(bench.run_controller().end_cause().find("the chamber was sent to 20 °C"), std::string::npos)
      << bench.run_controller().end_cause();
}

TEST(BrokenRig, RetriesSafeSequenceAndWarnsOperatorEachMinute) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.chamber().silent = true;
  bench.instruments().uut_c = 101;
  EXPECT_EQ(bench.seconds(605), RunOutcome::going_on);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::aborting);
  EXPECT_EQ(bench.record().samples.size(), 1105u) << "recording continues";
  EXPECT_NEAR(bench.count(EventKind::fault, "could NOT be sent to 20 °C"), 10, 2);
  EXPECT_NEAR(bench.chamber().immediate_set_points, 10 + 59, 3) << "immediately, but later less often";
  bench.chamber().silent = false;
  EXPECT_EQ(bench.seconds(10), RunOutcome::made_safe) << "within ten seconds after it answers again";
  EXPECT_EQ(bench.chamber().set_point_c, 20);
}

TEST(BrokenRig, ResendsSafeSetPointThatChanged) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.instruments().uut_c = 101;
  bench.seconds(2);
  ASSERT_EQ(bench.chamber().set_point_c, 20);
  bench.chamber().set_point_c = 55;
  EXPECT_EQ(bench.seconds(1), RunOutcome::going_on);
  EXPECT_EQ(bench.seconds(1), RunOutcome::made_safe);
}

TEST(BrokenRig, SafeSequenceMaySwitchChamberOff) {
  tests::Bench bench(kSoak, [](rig::RigFile& file) { file.safe_off = true; });
  bench.seconds(500);
  bench.chamber().must_stop = true;
  EXPECT_EQ(bench.seconds(2), RunOutcome::made_safe);
  EXPECT_FALSE(bench.chamber().on);
  EXPECT_EQ(bench.chamber().set_point_c, 20);
}

TEST(BrokenRig, SendsNothingAndStopsClockWhileHeld) {
  tests::Bench bench(kSoak);
  bench.seconds(130);
  bench.run_controller().submit(OperatorCommand::pause, "Ada");
  bench.seconds(1);
  ASSERT_EQ(bench.run_controller().run_state(), RunState::held);
  const auto before = bench.progress();
  const auto sent = bench.chamber().sent_c.size();
  bench.seconds(1000);
  EXPECT_EQ(bench.progress(), before);
  EXPECT_EQ(bench.chamber().sent_c.size(), sent);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  bench.seconds(1);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::execute);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  EXPECT_LE(largest_set_point_step(bench.chamber().sent_c), 5.0 / 60 * 5 + 1e-6);
}

TEST(BrokenRig, StopLeavesChamberAsRigSpecifies) {
  tests::Bench safe(kSoak);
  safe.seconds(500);
  EXPECT_EQ(safe.run_controller().overview().stopped_by_operator, false);
  safe.run_controller().submit(OperatorCommand::stop, "Ada");
  EXPECT_EQ(safe.seconds(3), RunOutcome::stopped);
  EXPECT_EQ(safe.run_controller().overview().stopped_by_operator, true);
  EXPECT_EQ(safe.chamber().set_point_c, 20);
  tests::Bench hold(kSoak, [](rig::RigFile& file) { file.run_limits.on_stop = interlocks::OnStop::hold; });
  hold.seconds(500);
  hold.run_controller().submit(OperatorCommand::stop, "Ada");
  EXPECT_EQ(hold.seconds(1), RunOutcome::stopped);
  EXPECT_EQ(hold.chamber().set_point_c, 30);
  EXPECT_EQ(hold.run_controller().end_cause(), "stopped by Ada");
  EXPECT_EQ(hold.run_controller().overview().stopped_by_operator, true);
  tests::Bench terminated(kSoak);
  terminated.seconds(500);
  terminated.run_controller().make_safe("stopped by SIGTERM");
  EXPECT_EQ(terminated.run_controller().overview().stopped_by_operator, false) << "no operator";
}

/// Returns nine thermometers. The certificate of the second states that it reads too high by `too_high`.
std::function<void(rig::RigFile&)> with_offset_of_b(Kelvins too_high) {
  return [too_high](rig::RigFile& file) {
    rig::ThermometerSettings settings;
    for (const char* name : {"A", "B", "C", "D", "E", "F", "G", "H", "shell"})
      settings.calibrated.push_back({.name = name, .instrument = {}, .offset = {}});
    settings.calibrated[1].offset = -too_high;
    file.thermometers = {settings};
  };
}

TEST(BrokenRig, CountsSoakBySensorOfProfile) {
  auto profile = kSoak;
  profile.insert(profile.find("soak_band = 1"), "soak_sensor = \"B\"\ndeadline = \"3 h\"\n");
  tests::Bench bench(profile, with_offset_of_b({}));
  EXPECT_EQ(bench.seconds(1500), RunOutcome::going_on) << "the air is in the band, the unit is not";
  EXPECT_EQ(bench.progress().phase, Phase::waiting_for_soak);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  EXPECT_TRUE(bench.told(EventKind::note, "soak of segment 3 ended: 10 min 00 s inside ±1 K of 30 °C on B, in"));
}

TEST(BrokenRig, CountsSoakByCalibratedTemperature) {
  auto profile = kSoak;
  profile.insert(profile.find("soak_band = 1"), "soak_sensor = \"B\"\ndeadline = \"3 h\"\n");
  tests::Bench bench(profile, with_offset_of_b({-6}));
  EXPECT_EQ(bench.seconds(9000), RunOutcome::going_on);
  EXPECT_EQ(bench.progress().phase, Phase::waiting_for_soak) << "a reading of 30 °C is a temperature of 36 °C";
  EXPECT_NEAR(to_seconds(bench.progress().soaked), 302, 30) << "while it changes from 29 to 31 °C";
}

/// Leaving the band restarts the dwell, also while the profile's clock is stopped.
TEST(BrokenRig, RestartsDwellWhenAirLeavesBandWhileHeld) {
  auto profile = kSoak;
  profile.insert(profile.find("soak_band = 1"), "soak_dwell = \"5 min\"\n");
  tests::Bench bench(profile);
  bench.seconds(900);
  ASSERT_GT(bench.progress().soaked, Duration{});
  bench.run_controller().submit(OperatorCommand::pause, "Ada");
  bench.chamber().door_open = true;
  bench.seconds(200);
  bench.chamber().door_open = false;
  bench.seconds(250);
  ASSERT_NEAR(bench.chamber().air_c, 30, 1) << "it is back before the clock runs again";
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  int inside = 0;
  Duration soaked{};
  for (const auto& sample : bench.record().samples) {
    if (sample.progress.segment != 2) continue;
    if (sample.progress.soaked > soaked) {
      ASSERT_GE(inside, 300) << sample.slot;
    }
    soaked = sample.progress.soaked;
    inside = std::abs(sample.chamber.value->air.value - 30) <= 1 ? inside + 1 : 0;
  }
}

TEST(BrokenRig, FinalRampReachesTarget) {
  tests::Bench bench(kSoak);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  EXPECT_EQ(bench.chamber().set_point_c, 20);
}

TEST(BrokenRig, AbortByOperatorMakesChamberSafe) {
  tests::Bench bench(kSoak);
  bench.seconds(500);
  bench.run_controller().submit(OperatorCommand::abort, "Ada");
  EXPECT_EQ(bench.seconds(3), RunOutcome::made_safe);
  EXPECT_EQ(bench.chamber().set_point_c, 20);
}

TEST(BrokenRig, LateSecondStopsClockWithoutSetPointJump) {
  tests::Bench bench(kSoak);
  bench.seconds(130);
  const auto before = bench.progress();
  bench.late(60);
  bench.seconds(1);
  EXPECT_EQ(bench.progress().in_segment - before.in_segment, std::chrono::seconds(1));
  EXPECT_EQ(bench.record().gap_seconds, 60);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
  EXPECT_LE(largest_set_point_step(bench.chamber().sent_c), 5.0 / 60 + 1e-6);
}

TEST(BrokenRig, OnlyOperatorResumesAfterLongSleep) {
  tests::Bench bench(kSoak);
  bench.seconds(400);
  bench.late(121);
  bench.seconds(1);
  ASSERT_EQ(bench.run_controller().run_state(), RunState::held);
  bench.seconds(1000);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
  bench.run_controller().submit(OperatorCommand::resume, "Ada");
  bench.seconds(1);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::execute);
}

/// A gyro that lost its data while the machine slept reports one fault. That is not a silence of an hour.
TEST(BrokenRig, TreatsSleepAsNoSilence) {
  tests::Bench bench(kSoak);
  bench.seconds(400);
  bench.late(3700);
  bench.instruments().gyro_silent = true;
  bench.seconds(1);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
  bench.instruments().gyro_silent = false;
  bench.seconds(60);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::held);
  EXPECT_FALSE(bench.told(EventKind::interlock, "silent"));
}

TEST(BrokenRig, TreatsLostReadingInLateSecondAsNoSilence) {
  tests::Bench bench(kSoak);
  bench.seconds(400);
  bench.late(6);
  bench.chamber().silent = true;
  bench.seconds(1);
  bench.chamber().silent = false;
  bench.seconds(10);
  EXPECT_EQ(bench.count(EventKind::interlock, ""), 0);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::execute);
}

TEST(BrokenRig, AttributesSecondsWithoutTickToChamberThatWasAwaited) {
  for (const bool waits : {true, false}) {
    tests::Bench bench(kSoak);
    bench.seconds(400);
    bench.instruments().over = waits ? std::chrono::milliseconds(200) : Duration{};
    bench.chamber().silent = true;
    for (int i = 0; i < 12; ++i) {
      bench.late(1);
      bench.seconds(1);
    }
    EXPECT_EQ(bench.record().gap_cause, waits ? "the program waited for the chamber" : "the program was late");
    EXPECT_EQ(bench.told(EventKind::fault, "1 s without a tick: " + bench.record().gap_cause), true);
    EXPECT_EQ(bench.told(EventKind::fault, "host_late"), !waits) << "only a late program shows a busy machine";
    EXPECT_EQ(bench.record().gap_seconds, 12) << "each second is accounted for";
  }
}

/// The run also waits if an operator resumed it after a long pause, or if the chamber does not answer in the first
/// second.
TEST(BrokenRig, WaitsForAirToReturnAfterPause) {
  for (const int pause : {100, 125})
    for (const bool silent : {false, true}) {
      tests::Bench bench(kSoak);
      bench.seconds(400);
      bench.chamber().door_open = true;
      bench.late(pause);
      bench.chamber().silent = silent;
      bench.seconds(1);
      bench.chamber().silent = false;
      bench.seconds(1);
      bench.chamber().door_open = false;
      ASSERT_LT(bench.chamber().air_c, 26);
      if (pause > 120) bench.run_controller().submit(OperatorCommand::resume, "Ada");
      ASSERT_NE(bench.until(RunState::execute, 2000), -1);
      EXPECT_NEAR(bench.chamber().air_c, 30, 2) << pause << " " << silent;
    }
}

TEST(BrokenRig, RampsToFirstSetPointBeforeClockStarts) {
  tests::Bench bench(kSoak);
  bench.chamber().air_c = bench.chamber().set_point_c = 40;
  bench.run_controller().begin_away(Celsius{40}, "the air is elsewhere", {});
  bench.seconds(100);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::suspended);
  EXPECT_EQ(bench.progress().in_segment, Duration{});
  ASSERT_NE(bench.until(RunState::execute, 2000), -1);
  EXPECT_NEAR(bench.chamber().air_c, 20, 2);
  EXPECT_LE(largest_set_point_step(bench.chamber().sent_c), 6.0 / 60 + 1e-6);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
}

TEST(BrokenRig, RampsFromNearbyAirWhileClockRuns) {
  tests::Bench bench(kSoak);
  bench.chamber().air_c = bench.chamber().set_point_c = 21.5;
  bench.run_controller().begin_behind(Celsius{21.5});
  bench.seconds(5);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::execute);
  EXPECT_GE(bench.progress().in_segment, 4 * kSecond);
  EXPECT_NEAR(bench.chamber().set_point_c, 21, 0.2);
  bench.seconds(20);
  EXPECT_EQ(bench.chamber().set_point_c, 20);
  EXPECT_LE(largest_set_point_step(bench.chamber().sent_c), 6.0 / 60 + 1e-6);
  EXPECT_EQ(bench.seconds(5000), RunOutcome::complete);
}

TEST(BrokenRig, SendsNothingToSilentChamberAndAbortsLostOne) {
  tests::Bench bench(kSoak);
  bench.seconds(130);
  bench.chamber().silent = true;
  EXPECT_EQ(bench.until(RunState::suspended, 20), 5);
  EXPECT_EQ(bench.until(RunState::aborting, 2000), 595);
}

TEST(BrokenRigDeathTest, ViolatedSafetyInvariantEndsProcess) {
  EXPECT_DEATH(
      {
        tests::Bench bench(kSoak, [](rig::RigFile& file) { file.chamber_limits.highest = {25}; });
        bench.seconds(400);
      },
      "a set point lies within the limits");
}

TEST(BrokenRigDeathTest, SetPointFasterThanRampLimitEndsProcess) {
  EXPECT_DEATH(
      // Limits that no rig file can have: heating at −6 °C/min cools, and faster than permitted.
      {
        tests::Bench bench(kSoak, [](rig::RigFile& file) {
          file.chamber_limits.fastest_heating = {-6};
          file.chamber_limits.fastest_cooling = {1};
        });
        bench.seconds(400);
      },
      "a set point moves no faster than the ramp limit");
}

}  // namespace
}  // namespace gyrotherm::run
