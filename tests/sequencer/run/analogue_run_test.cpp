// SPDX-License-Identifier: Apache-2.0
// Runs with values of units that analogue inputs measure.
#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/record/chain.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/run/dropped_units.hpp"
#include "sequencer/run/resume.hpp"
#include "tests/support/bench_rig.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

const std::string kTenSeconds = GYROTHERM_SOURCE_DIR "/tests/profiles/ten-seconds.toml";

/// Returns the columns of the record that do not come from an analogue input.
std::vector<double> columns_without_analogue_inputs(const record::Record& record) {
  std::vector<double> all = record.chamber_air_c;
  for (const auto& thermometer : record.thermometers_c) all.insert(all.end(), thermometer.begin(), thermometer.end());
  for (const auto& unit : record.units) {
    for (const auto& axis : unit.rotation) all.insert(all.end(), axis.begin(), axis.end());
    all.insert(all.end(), unit.interval_s.begin(), unit.interval_s.end());
  }
  return all;
}

TEST(AnalogueInputs, AreRecordedAsValuesOfTheirUnits) {
  tests::DryRun dry_run(kTenSeconds, 0, "virtual-triad");
  EXPECT_EQ(dry_run.run(), RunOutcome::complete);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_TRUE(record::verify_record(dry_run.path()));
  for (const auto& unit : record->units) {
    ASSERT_EQ(unit.values.size(), 1u);
    ASSERT_EQ(unit.values[0].size(), record->slot.size());
    for (const double current : unit.values[0]) EXPECT_NEAR(current, 1.0, 0.01);
  }
  EXPECT_NE(record->units[0].values[0], record->units[1].values[0]) << "each unit has its own";
  EXPECT_EQ(record->info.units[2].values[0].instrument, "ioLogik E1240 at virtual, input 3");
  EXPECT_EQ(record->info.analogue_map_texts, collect_analogue_map_texts(dry_run.file()));
}

TEST(AnalogueInputs, DoNotChangeOtherColumns) {
  tests::DryRun with(kTenSeconds, 0, "virtual-triad");
  EXPECT_EQ(with.run(), RunOutcome::complete);
  const auto other = columns_without_analogue_inputs(record::read_record(with.path()).value());
  std::filesystem::remove(with.path());

  const auto path = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-triad.toml";
  auto plain = read_text_file(path).value();
  const auto cut = [&](const std::string& from, const std::string& to) {
    const auto at = plain.find(from);
    plain.erase(at, plain.find(to, at) - at);
  };
  cut("[[analogue_input]]", "# Interlocks.");
  cut("[[virtual.value]]", "# share:");
  with.file() = rig::parse_rig(plain, path).value();
  EXPECT_EQ(with.run(), RunOutcome::complete);
  EXPECT_EQ(columns_without_analogue_inputs(record::read_record(with.path()).value()), other);
}

TEST(AnalogueInputs, ResumeFromRecordOnly) {
  tests::DryRun dry_run(kTenSeconds, 0, "virtual-triad");
  EXPECT_EQ(dry_run.run(4), RunOutcome::going_on);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  const auto on = plan_continuation(*record, dry_run.path(), kSecond, 1);
  ASSERT_TRUE(on) << text(on.error());
  ASSERT_EQ(on->rig.analogue_inputs.size(), 1u);
  EXPECT_EQ(on->rig.analogue_inputs[0].map.inputs, dry_run.file().analogue_inputs[0].map.inputs);
  auto rig = rig::Rig::assemble(on->rig, on->start);
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_TRUE((*rig)->prepare(Celsius{20}));
  (*rig)->let_pass(1);
  const auto sample = (*rig)->io().read(5, (*rig)->clock());
  for (const auto& unit : sample.units) {
    ASSERT_EQ(unit.analogue.size(), 1u);
    ASSERT_TRUE(unit.analogue[0].value);
    EXPECT_NEAR(*unit.analogue[0].value, 1.0, 0.01);
  }
}

/// Returns a sample of two units. The first has two analogue values, and the second of them is silent.
Sample half_silent_sample() {
  Sample sample;
  sample.chamber = {ChamberState{{20}, {20}}, {}};
  sample.thermometers = {{Celsius{20}, {}}};
  sample.units.resize(2);
  for (auto& unit : sample.units) unit.count = {GyroCount{{1}, kSecond}, {}};
  sample.units[0].analogue = {{1.0, {}}, {failure(FaultKind::timeout, "analogue input 1", "no reply in 300 ms"), {}}};
  return sample;
}

TEST(AnalogueInputs, WarnWhenSilentAndContinue) {
  interlocks::InterlockLimits limits;
  limits.units = {{.name = "u1", .analogue = {"intensity", "current"}}, {.name = "u2"}};
  const auto result = interlocks::judge(limits, {}, half_silent_sample(), kSecond, {});
  ASSERT_EQ(result.raised.size(), 1u);
  EXPECT_EQ(result.raised[0].id, interlocks::InterlockId::channel_lost);
  EXPECT_EQ(result.raised[0].reaction, interlocks::Reaction::warn);
  EXPECT_EQ(result.raised[0].text, "no reading of u1.current");
  EXPECT_EQ(result.demand.reaction, interlocks::Reaction::warn);
}

TEST(AnalogueInputs, RecordSilenceAsEventOfTheirChannel) {
  tests::Bench bench("[[segment]]\nkind = \"hold\"\nat = \"20 °C\"\ntime = \"1 h\"\n", [](rig::RigFile& file) {
    file.limits.units = {{.name = file.units[0].info.name, .analogue = {"intensity", "current"}}};
  });
  auto& analogue = bench.instruments().analogue;
  analogue = {0.5, 1.0};
  bench.seconds(5);
  analogue[1] = failure(FaultKind::timeout, "analogue input 1", "no reply in 300 ms");
  EXPECT_EQ(bench.seconds(1800), RunOutcome::going_on);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::execute);
  EXPECT_EQ(bench.count(EventKind::fault, "gyro.current: analogue input 1: no reply in 300 ms"), 1) << "reported once";
  EXPECT_EQ(bench.count(EventKind::fault, "channel_lost (warn): no reading of gyro.current"), 1);
  EXPECT_FALSE(bench.told(EventKind::fault, "intensity"));
  EXPECT_FALSE(bench.record().samples.back().units[0].analogue[1].value);
  EXPECT_EQ(bench.record().samples.back().units[0].analogue[0].value, 0.5);
  analogue[1] = 1.0;
  bench.seconds(30);
  EXPECT_TRUE(bench.told(EventKind::recovered, "gyro.current answers again"));
  EXPECT_TRUE(bench.told(EventKind::recovered, "channel_lost is over"));
}

TEST(AnalogueInputs, HaveNeitherValueNorFaultWhenUnitIsDropped) {
  DroppedUnits units({"u1", "u2"});
  units.carry_out({.drop = true, .unit = "u1"});
  auto sample = half_silent_sample();
  sample.units[1].analogue = {{2.5, {}}};
  units.clear_readings(sample);
  for (const auto& analogue : sample.units[0].analogue) {
    ASSERT_TRUE(analogue.value);
    EXPECT_TRUE(std::isnan(*analogue.value));
  }
  EXPECT_EQ(sample.units[1].analogue[0].value, 2.5);
}

}  // namespace
}  // namespace gyrotherm::run
