// SPDX-License-Identifier: Apache-2.0
/// Runs on a rig whose power supply the program switches.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "sequencer/run/resume.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

const std::string kColdStarts = GYROTHERM_SOURCE_DIR "/tests/profiles/short-cold-starts.toml";
constexpr const char* kSupplyRig = "virtual-supply";

std::vector<std::string> power_event_texts(const std::string& path, EventKind kind) {
  std::vector<std::string> texts;
  const auto record = record::read_record(path).value();
  for (const auto& recorded : record.events)
    if (recorded.event.kind == kind) texts.push_back(recorded.event.text);
  return texts;
}

bool has_power_alarm(const std::string& path, const std::string& interlock) {
  const auto record = record::read_record(path).value();
  return std::ranges::any_of(record.events, [&](const auto& recorded) {
    return recorded.event.about.interlock == interlock && recorded.event.kind != EventKind::recovered;
  });
}

/// Returns whether two columns are equal, with missing values in the same rows.
void expect_same_columns(const std::vector<double>& one, const std::vector<double>& other) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(std::isnan(one[i]), std::isnan(other[i])) << i;
    if (std::isnan(one[i])) continue;
    ASSERT_EQ(one[i], other[i]) << i;
  }
}

/// The rig with a supply gives the same measurements as the rig whose gyro people switch.
TEST(PowerRun, SwitchesTheUnitWithoutAPerson) {
  tests::DryRun by_people(kColdStarts);
  ASSERT_EQ(by_people.run(), RunOutcome::complete);
  const auto expected = record::read_record(by_people.path()).value();
  std::filesystem::remove(by_people.path());
  tests::DryRun dry_run(kColdStarts, 0, kSupplyRig);
  ASSERT_EQ(dry_run.run(), RunOutcome::complete);
  const auto record = record::read_record(dry_run.path()).value();
  EXPECT_EQ(record.slot.size(), 370u) << "the run does not wait";
  ASSERT_EQ(record.info.units[0].values.size(), 2u);
  EXPECT_EQ(record.info.units[0].values[0].name, "supply_voltage_v");
  EXPECT_EQ(record.info.units[0].values[0].instrument, "Keysight E36312A at virtual, output 1");
  EXPECT_EQ(record.info.supply_texts, collect_supply_texts(dry_run.file()));
  expect_same_columns(record.units[0].rotation[0], expected.units[0].rotation[0]);
  expect_same_columns(record.thermometers_c[0], expected.thermometers_c[0]);
  for (std::size_t i = 0; i < record.slot.size(); ++i) {
    const bool is_on = i < 10 || (i - 10) % 120 >= 60;
    EXPECT_DOUBLE_EQ(record.units[0].values[0][i], is_on ? 24 : 0) << i;
    EXPECT_NEAR(record.units[0].values[1][i], is_on ? 0.5 : 0, 0.05) << i;
  }
  const auto notes = power_event_texts(dry_run.path(), EventKind::note);
  EXPECT_EQ(std::ranges::count_if(notes, [](const auto& text) { return text.starts_with("supply 1 is off: "); }), 3);
  EXPECT_EQ(std::ranges::count_if(notes, [](const auto& text) { return text.starts_with("supply 1 is on: "); }), 4);
  EXPECT_EQ(power_event_texts(dry_run.path(), EventKind::fault), std::vector<std::string>{});
}

TEST(PowerRun, AsksAPersonOnlyForUnitsWithoutASupply) {
  const auto profile = profile::parse_profile(read_text_file(kColdStarts).value(), kColdStarts).value();
  const auto all = profile::switch_by_supplies(profile, {});
  for (const auto& segment : all.segments) EXPECT_EQ(segment.prompt, "");
  const auto some = profile::switch_by_supplies(profile, {"y", "z"});
  EXPECT_EQ(some.segments[1].prompt, "switch y, z off");
  EXPECT_EQ(some.segments[2].prompt, "switch y, z on");
}

TEST(PowerRun, HoldsOnOverCurrent) {
  tests::DryRun dry_run(kColdStarts, 0, kSupplyRig);
  dry_run.file().supplies[0].outputs[0].current.highest = 0.4;
  (void)dry_run.run({}, nullptr, [](tests::RunHarness& harness, rig::Rig&) {
    EXPECT_EQ(harness.until(RunState::held, 3), 2) << "two readings confirm it";
    harness.seconds(5);
    EXPECT_EQ(harness.run_controller().run_state(), RunState::held);
    const auto cause = harness.run_controller().overview().cause;
    EXPECT_NE(cause.find("is above 0.4 A"), std::string::npos) << cause;
    EXPECT_NE(harness.run_controller().refusal_reason(OperatorCommand::resume), "");
  });
  EXPECT_TRUE(has_power_alarm(dry_run.path(), "power_limit"));
}

/// The rig whose gyro takes much more current when it is colder.
rig::RigFile rig_with_cold_load() {
  const auto path = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-supply.toml";
  auto text_of_rig = read_text_file(path).value();
  const std::string load = "ohm = 48.0\nper_k = 0.001";
  text_of_rig.replace(text_of_rig.find(load), load.size(), "ohm = 4.8\nper_k = 0.1");
  auto rig = rig::parse_rig(text_of_rig, path);
  EXPECT_TRUE(rig) << text(rig.error());
  auto& output = rig->supplies[0].outputs[0];
  output.settings.current_a = output.settings.over_current_a.emplace(10);
  output.current = {};
  return std::move(*rig);
}

/// The gyro takes more current after a minute without power than before. The supply trips in between.
TEST(PowerRun, HoldsOnTripUntilOperatorActs) {
  tests::DryRun dry_run(kColdStarts, 0, kSupplyRig);
  dry_run.file() = rig_with_cold_load();
  (void)dry_run.run(80);
  const auto before = record::read_record(dry_run.path()).value();
  std::filesystem::remove(dry_run.path());
  const auto& current_a = before.units[0].values[1];
  ASSERT_GT(current_a[71], current_a[9] + 0.004);
  auto& settings = dry_run.file().supplies[0].outputs[0].settings;
  settings.current_a = settings.over_current_a.emplace((current_a[9] + current_a[71]) / 2);
  (void)dry_run.run({}, nullptr, [](tests::RunHarness& harness, rig::Rig& rig) {
    EXPECT_EQ(harness.until(RunState::held, 80), 71);
    auto& run = harness.run_controller();
    EXPECT_NE(run.overview().cause.find("tripped: over_current"), std::string::npos) << run.overview().cause;
    harness.seconds(30);
    EXPECT_EQ(rig.io().supplies().at(0).outputs.at(0)->is_on, false) << "nothing switches it on again";
    EXPECT_EQ(run.refusal_reason(OperatorCommand::resume), "");
    run.submit(OperatorCommand::resume, "ada");
    harness.seconds(15);
    EXPECT_EQ(run.run_state(), RunState::held) << "it has tripped again";
    EXPECT_EQ(rig.io().supplies().at(0).outputs.at(0)->is_on, false);
  });
  EXPECT_TRUE(has_power_alarm(dry_run.path(), "power_trip"));
}

TEST(PowerRun, SwitchesOffOnAbortIfRigSaysSo) {
  for (const bool is_off : {false, true}) {
    tests::DryRun dry_run(kColdStarts, 0, kSupplyRig);
    dry_run.file().supplies[0].is_off_on_stop = is_off;
    (void)dry_run.run({}, nullptr, [&](tests::RunHarness& harness, rig::Rig& rig) {
      harness.seconds(5);
      harness.run_controller().submit(OperatorCommand::abort, "ada");
      harness.seconds(400);
      EXPECT_EQ(harness.outcome(), RunOutcome::made_safe);
      EXPECT_EQ(rig.io().supplies().at(0).outputs.at(0)->is_on, !is_off);
      const auto cause = harness.run_controller().end_cause();
      EXPECT_EQ(cause.ends_with("; supply 1 off"), is_off) << cause;
    });
    std::filesystem::remove(dry_run.path());
  }
}

TEST(PowerRun, SilenceOfUnitThatStopSwitchesOffIsNoFault) {
  for (const bool is_off : {false, true}) {
    tests::DryRun dry_run(kColdStarts, 0, kSupplyRig);
    dry_run.file().supplies[0].is_off_on_stop = is_off;
    (void)dry_run.run({}, nullptr, [&](tests::RunHarness& harness, rig::Rig&) {
      harness.seconds(5);
      harness.run_controller().submit(OperatorCommand::stop, "ada");
      harness.seconds(400);
      EXPECT_EQ(harness.outcome(), RunOutcome::stopped);
    });
    EXPECT_FALSE(has_power_alarm(dry_run.path(), "gyro_silent")) << is_off;
    std::filesystem::remove(dry_run.path());
  }
}

/// Returns the continuation of a run that was killed after `seconds`.
RunContinuation kill_supplied_run(tests::DryRun& dry_run, std::int64_t seconds) {
  EXPECT_EQ(dry_run.run(seconds), RunOutcome::going_on);
  auto on = plan_continuation(record::read_record(dry_run.path()).value(), dry_run.path(), kSecond, 0);
  EXPECT_TRUE(on) << text(on.error());
  return std::move(*on);
}

TEST(PowerRun, ReadsTheSupplyOnAResume) {
  tests::DryRun dry_run(kColdStarts, 0, kSupplyRig);
  ASSERT_EQ(dry_run.run(), RunOutcome::complete);
  const auto whole = record::read_record(dry_run.path()).value();
  std::filesystem::remove(dry_run.path());
  for (const std::int64_t killed : {40, 100}) {
    const auto on = kill_supplied_run(dry_run, killed);
    EXPECT_EQ(on.start.power, drivers::PowerDemand::keep);
    auto rig = rig::Rig::assemble(on.rig, on.start);
    ASSERT_TRUE(rig) << text(rig.error());
    ASSERT_TRUE((*rig)->prepare(Celsius{20}));
    (*rig)->let_pass(1);
    const auto sample = (*rig)->io().read(0, (*rig)->clock());
    const auto slot = static_cast<std::size_t>(on.start.elapsed / std::chrono::seconds(1));
    ASSERT_EQ(sample.units[0].analogue.size(), 2u);
    EXPECT_DOUBLE_EQ(sample.units[0].analogue[0].value.value(), whole.units[0].values[0][slot]) << killed;
    EXPECT_EQ(sample.thermometers[0].value->value, whole.thermometers_c[0][slot]) << killed;
    std::filesystem::remove(dry_run.path());
  }
}

/// The supply was switched off while the program was not running. Only an operator switches it on.
TEST(PowerRun, DoesNotSwitchOnByItselfAfterAResume) {
  tests::DryRun dry_run(kColdStarts, 0, kSupplyRig);
  auto on = kill_supplied_run(dry_run, 100);
  on.start.replay.back().powered = {false};
  auto rig = rig::Rig::assemble(on.rig, on.start);
  ASSERT_TRUE(rig) << text(rig.error());
  const auto prepared = (*rig)->prepare(Celsius{20});
  ASSERT_TRUE(prepared) << text(prepared.error());
  auto store = record::Store::reopen(dry_run.path());
  ASSERT_TRUE(store) << text(store.error());
  const auto first = on.start.elapsed / std::chrono::seconds(1);
  ASSERT_TRUE((*store)->append_gap(on.last_slot + 1, first - 1, "the program was not running"));
  RunController run(on.profile, **rig, **store, on.state, first);
  std::int64_t slot = first;
  const auto seconds = [&](int count) {
    for (; count > 0; --count) {
      (*rig)->let_pass(1);
      ASSERT_TRUE(run.tick(slot++));
    }
  };
  seconds(5);
  EXPECT_EQ(run.run_state(), RunState::held);
  EXPECT_NE(run.overview().cause.find("supply 1, output 1 was switched off"), std::string::npos)
      << run.overview().cause;
  EXPECT_FALSE((*rig)->io().supplies().at(0).outputs.at(0)->is_on);
  ASSERT_EQ(run.refusal_reason(OperatorCommand::resume), "");
  run.submit(OperatorCommand::resume, "ada");
  seconds(5);
  EXPECT_TRUE((*rig)->io().supplies().at(0).outputs.at(0)->is_on);
  EXPECT_EQ(run.run_state(), RunState::execute);
}

}  // namespace
}  // namespace gyrotherm::run
