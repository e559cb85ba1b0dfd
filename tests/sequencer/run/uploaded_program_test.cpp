// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "sequencer/run/chamber_lead.hpp"
#include "tests/sequencer/profile/profiles.hpp"
#include "tests/support/bench_rig.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

const std::string kHour = GYROTHERM_SOURCE_DIR "/tests/profiles/qualification-hour.toml";

drivers::RegisterMap shipped_map(const std::string& name) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml");
  return drivers::parse_register_map(text.value(), name + ".toml").value();
}

/// Runs the laboratory's profile on the controller of `map`. Calls `before` before each slot's tick.
RunOutcome upload_and_run(tests::DryRun& dry_run, const std::string& map, std::string& cause,
                          const std::function<void(std::int64_t slot, rig::Rig& rig)>& before = {}) {
  dry_run.file().chamber_map = shipped_map(map);
  const auto program = make_chamber_program(dry_run.profile());
  EXPECT_TRUE(program) << text(program.error());
  return dry_run.run({}, &*program, [&](tests::RunHarness& harness, rig::Rig& rig) {
    if (before) harness.before_second = [&](std::int64_t slot) { before(slot, rig); };
    harness.seconds(1'000'000);
    cause = harness.run_controller().end_cause();
  });
}

/// During the sleep the controller completes a soak, and does not repeat it.
TEST(UploadedProgram, ContinuesWhileMachineSleeps) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/soaks.toml");
  dry_run.file().chamber_map = shipped_map("watlow_f4t");
  const auto program = make_chamber_program(dry_run.profile());
  ASSERT_TRUE(program) << text(program.error());
  const auto outcome = dry_run.run({}, &*program, [](tests::RunHarness& harness, rig::Rig&) {
    harness.seconds(400);
    ASSERT_EQ(harness.progress().segment, 1) << "on its way to 5 °C";
    harness.without_tick(1200);
    harness.seconds(1);
    EXPECT_EQ(harness.progress().segment, 3) << "on its way to 35 °C";
    harness.seconds(3 * 3600);
  });
  EXPECT_EQ(outcome, RunOutcome::complete);
}

/// The air is at 20 °C before and after, not at the 30 °C of the soak.
TEST(UploadedProgram, CountsNoSoakInLateSecondWithAirOutsideBand) {
  tests::Bench bench(
      "[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"10 min\"\nguaranteed_soak = true\nsoak_band = \"1 K\"\n");
  bench.run_controller().hand_over_to_controller();
  bench.seconds(10);
  bench.late(100);
  bench.seconds(1);
  EXPECT_EQ(bench.record().samples.back().progress.soaked, Duration{});
  bench.late(200);
  bench.seconds(1);
  EXPECT_GE(bench.record().samples.back().progress.soaked, std::chrono::seconds(200))
      << "after a sleep the position is unknown";
}

/// One second in which the controller pauses is no reason to end the program, however long the program was late.
TEST(UploadedProgram, IsNotEndedForSecondAfterLateOne) {
  for (const int missed : {61, 3600}) {
    tests::Bench bench("[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"3 h\"\n");
    bench.run_controller().hand_over_to_controller();
    bench.seconds(10);
    bench.chamber().door_open = true;
    bench.late(missed);
    bench.seconds(1);
    bench.chamber().door_open = false;
    bench.seconds(5);
    EXPECT_EQ(bench.run_controller().run_state(), RunState::execute) << bench.run_controller().end_cause();
  }
}

class EachController : public testing::TestWithParam<const char*> {};

TEST_P(EachController, CarriesOutProgram) {
  tests::DryRun dry_run(kHour);
  std::string cause;
  ASSERT_EQ(upload_and_run(dry_run, GetParam(), cause), RunOutcome::complete) << cause;
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  ASSERT_EQ(record->slot.size(), 3600u);
  for (std::size_t i = 0; i < record->slot.size(); ++i)
    ASSERT_NEAR(record->chamber_set_point_c[i], record->set_point_c[i], 0.11) << "second " << i;
}

TEST_P(EachController, HasLowerPriorityThanInterlocks) {
  tests::DryRun dry_run(kHour);
  dry_run.file().limits.thermometers_lowest = {10};
  std::string cause;
  ASSERT_EQ(upload_and_run(dry_run, GetParam(), cause), RunOutcome::made_safe);
  EXPECT_NE(cause.find("thermometer shell reads"), std::string::npos) << cause;
  EXPECT_NE(cause.find("was sent to 20 °C"), std::string::npos) << cause;
}

TEST_P(EachController, EndsRunWhenProgramIsEndedAtPanel) {
  tests::DryRun dry_run(kHour);
  std::string cause;
  // A set point ends the program, like an operator at the panel.
  const auto end_it = [](std::int64_t slot, rig::Rig& rig) {
    if (slot != 400) return;
    ASSERT_TRUE(rig.io().send_set_point({0}));
  };
  ASSERT_EQ(upload_and_run(dry_run, GetParam(), cause, end_it), RunOutcome::made_safe);
  EXPECT_NE(cause.find("the controller has not run its program"), std::string::npos) << cause;
}

INSTANTIATE_TEST_SUITE_P(Controllers, EachController, testing::Values("watlow_f4t", "csz_ezt570i", "binder_mb2"),
                         [](const auto& one) { return std::string(one.param); });

const std::string kHold30 = "[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"10 min\"\n";

void hold_on_stop(rig::RigFile& file) {
  file.run_limits.on_stop = interlocks::OnStop::hold;
  file.safe_set_point = {25};
}

/// Stops a run whose chamber's controller has the program.
void upload_and_stop(tests::Bench& bench, bool silent) {
  bench.run_controller().hand_over_to_controller();
  bench.seconds(10);
  bench.chamber().silent = silent;
  bench.run_controller().submit(OperatorCommand::stop, "Ada");
  bench.seconds(1);
}

TEST(UploadedProgram, IsEndedOrChamberMadeSafeWhenRunIsStopped) {
  tests::Bench answers(kHold30, hold_on_stop), silent(kHold30, hold_on_stop);
  upload_and_stop(answers, false);
  EXPECT_EQ(answers.run_controller().run_state(), RunState::stopped);
  EXPECT_EQ(answers.chamber().set_point_c, 30);
  upload_and_stop(silent, true);
  ASSERT_EQ(silent.run_controller().run_state(), RunState::aborting) << "the controller continues its program";
  EXPECT_TRUE(silent.told(EventKind::fault, "cannot be left at its set point"));
  silent.chamber().silent = false;
  EXPECT_EQ(silent.seconds(3), RunOutcome::stopped);
  EXPECT_EQ(silent.chamber().set_point_c, 25);
}

TEST(UploadedProgram, IsMadeSafeWhenInterlockAbortsDuringStop) {
  tests::Bench bench(kHold30, hold_on_stop);
  bench.run_controller().hand_over_to_controller();
  bench.seconds(10);
  bench.chamber().sent_c.clear();
  bench.chamber().must_stop = true;
  bench.run_controller().submit(OperatorCommand::stop, "Ada");
  bench.seconds(1);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::aborting);
  EXPECT_EQ(bench.chamber().sent_c, std::vector<double>{25}) << "only the safe set point";
}

TEST(UploadedProgram, HasSameSegmentsAsProfile) {
  const auto program = make_chamber_program(profile::parse_profile(read_text_file(kHour).value(), kHour).value());
  ASSERT_TRUE(program);
  EXPECT_EQ(program->name, "QUALIFICATIONHOUR");
  ASSERT_EQ(program->steps.size(), 7u);
  EXPECT_EQ(program->steps[1].kind, drivers::StepKind::ramp);
  EXPECT_EQ(program->steps[1].start, Celsius{20});
  EXPECT_EQ(program->steps[1].target, Celsius{-40});
  EXPECT_EQ(program->steps[1].duration, std::chrono::minutes(12));
}

TEST(UploadedProgram, IsRefusedForSoaksWithDifferentBands) {
  const auto profile = profile::parsed(profile::kHold20 + R"(guaranteed_soak = true
soak_band = 1
[[segment]]
kind = "hold"
time = "10 min"
guaranteed_soak = true
soak_band = 2
)");
  EXPECT_EQ(make_chamber_program(profile).error().kind, FaultKind::usage);
}

/// Returns the reason for refusing a soak of 100 s with these additional keys; empty if it is accepted.
std::string soak_refusal_reason(const std::string& keys) {
  const auto program = make_chamber_program(profile::parsed(profile::kHold20 + "guaranteed_soak = true\n" + keys));
  if (program) return "nothing";
  EXPECT_EQ(program.error().kind, FaultKind::usage);
  return text(program.error());
}

TEST(UploadedProgram, IsRefusedForSoakThatControllerWouldEndOtherwise) {
  EXPECT_EQ(soak_refusal_reason("soak_sensor = \"A\"\n"),
            "p.toml:4:1: a controller soaks on its own air sensor, but soak_sensor is \"A\"");
  EXPECT_EQ(soak_refusal_reason("soak_slope = 0.2\n"),
            "p.toml:4:1: a controller does not wait for steady air, but soak_slope is 0.2 °C/min");
  EXPECT_EQ(soak_refusal_reason("soak_dwell = \"50 s\"\n"),
            "p.toml:4:1: a controller counts from the first second in the band, but soak_dwell is 50 s");
  EXPECT_EQ(soak_refusal_reason("soak_time = \"99 s\"\n"),
            "p.toml:4:1: a controller requires the whole hold inside the band, but soak_time is 99 s of 100 s");
}

TEST(UploadedProgram, IsRefusedForHoldWithSetPointJump) {
  EXPECT_EQ(soak_refusal_reason("[[segment]]\nkind = \"hold\"\nat = 60\ntime = \"1 h\"\nguaranteed_soak = true\n"),
            "p.toml:9:1: a controller jumps from 20 °C to 60 °C, expected a ramp before this hold");
}

TEST(UploadedProgram, SoaksByControllerAirForTimeOfProfile) {
  EXPECT_EQ(soak_refusal_reason("soak_sensor = \"air\"\nsoak_time = \"100 s\"\n"), "nothing");
  const auto longer = profile::parsed(profile::kHold20 + "guaranteed_soak = true\nsoak_time = \"150 s\"\n");
  EXPECT_EQ(make_chamber_program(longer).value().steps.at(0).duration, std::chrono::seconds(150));
}

TEST(UploadedProgram, IgnoresSoakDefaultsForHoldWithoutSoak) {
  EXPECT_TRUE(make_chamber_program(
      profile::parsed("[defaults]\nsoak_sensor = \"A\"\nsoak_slope = 0.2\nsoak_time = \"1 s\"\n" + profile::kHold20)));
}

TEST(UploadedProgram, IsRefusedWithPrompts) {
  const auto profile = profile::parsed(profile::kHold20 + "prompt = \"look at the window\"\n");
  EXPECT_EQ(make_chamber_program(profile).error().where, "p.toml:4:1");
}

TEST(UploadedProgram, MayFinishOnlyInLastSegment) {
  ControllerLead lead({0.1});
  const auto after = [&](ChamberActivity activity, bool last) {
    Sample sample;
    sample.chamber = {ChamberState{{20}, {20}, activity}, {}};
    interlocks::InterlockInputs inputs;
    lead.fill_inputs(
        {.sample = sample, .goal = {20}, .missed = std::chrono::seconds(58), .in_last_segment = last, .end = {20}},
        inputs);
    return inputs.program;
  };
  EXPECT_EQ(after(ChamberActivity::program, false), "");
  EXPECT_EQ(after(ChamberActivity::running, false), "");
  EXPECT_NE(after(ChamberActivity::running, false), "");
  EXPECT_EQ(after(ChamberActivity::done, true), "");
  EXPECT_EQ(after(ChamberActivity::done, true), "");
}

}  // namespace
}  // namespace gyrotherm::run
