// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/dropped_units.hpp"

#include <gtest/gtest.h>

#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

constexpr const char* kHold = "[[segment]]\nkind = \"hold\"\nat = \"20 °C\"\ntime = \"1 h\"\n";

control::UnitRequest drop(const std::string& unit) { return {.drop = true, .unit = unit}; }
control::UnitRequest return_unit(const std::string& unit) { return {.drop = false, .unit = unit}; }

TEST(DroppedUnits, ExcludeReturnedUnits) {
  DroppedUnits units({"u1", "u2", "u3"});
  EXPECT_EQ(units.refusal_reason(drop("u4")), "\"u4\" is not a unit of this run, expected one of u1, u2, u3");
  EXPECT_EQ(units.refusal_reason(return_unit("u1")), "u1 is not dropped");
  EXPECT_EQ(units.refusal_reason(drop("u1")), "");
  units.carry_out(drop("u1"));
  EXPECT_EQ(units.refusal_reason(drop("u1")), "u1 is dropped already");
  units.carry_out(drop("u3"));
  EXPECT_EQ(units.refusal_reason(drop("u2")), "u2 is the only unit left; \"stop\" ends the run");
  EXPECT_EQ(units.all(), (std::vector{true, false, true}));
  units.carry_out(return_unit("u1"));
  EXPECT_EQ(units.all(), (std::vector{false, false, true}));
}

TEST(DroppedUnits, IncludeEmptyPositionsForWholeRun) {
  DroppedUnits units({"u1", "u2", "u3"}, {"u2"});
  EXPECT_EQ(units.all(), (std::vector{false, true, false}));
  EXPECT_EQ(units.refusal_reason(return_unit("u2")), "the position u2 is empty in this run");
  EXPECT_EQ(units.refusal_reason(drop("u2")), "the position u2 is empty in this run");
  units.carry_out(drop("u1"));
  EXPECT_EQ(units.refusal_reason(drop("u3")), "u3 is the only unit left; \"stop\" ends the run");
}

TEST(DroppedUnits, HaveNeitherReadingNorFault) {
  DroppedUnits units({"u1", "u2"});
  units.carry_out(drop("u1"));
  Sample sample;
  sample.units = {{.count = {failure(FaultKind::timeout, "gyro", "nothing came"), {}}},
                  {.count = {GyroCount{{7}, kSecond}, {}}}};
  units.clear_readings(sample);
  ASSERT_TRUE(sample.units[0].count.value);
  EXPECT_TRUE(sample.units[0].count.value->pulses.empty());
  EXPECT_EQ(sample.units[1].count.value->pulses, std::vector<std::int64_t>{7})
      << "the values of the others are unchanged";
}

TEST(DroppedUnits, AreRestoredFromRecordOfResumedRun) {
  const auto event = [](EventKind kind, const char* unit) {
    return record::RecordedEvent{0, {{}, kind, "", {.channel = unit}}};
  };
  record::Record record;
  record.events = {event(EventKind::dropped, "u1"), event(EventKind::dropped, "u2"), event(EventKind::fault, "u3"),
                   event(EventKind::returned, "u1")};
  EXPECT_EQ(find_dropped_units(record), std::vector<std::string>{"u2"});
  DroppedUnits units({"u1", "u2"});
  units.drop(find_dropped_units(record));
  EXPECT_EQ(units.all(), (std::vector{false, true}));
}

/// Returns a rig with two units. With `go_on`, the run continues for the other unit if one falls silent.
std::function<void(rig::RigFile&)> make_two_units(bool go_on) {
  return [go_on](rig::RigFile& file) {
    file.units = {rig::UnitSettings{}, rig::UnitSettings{}};
    file.units[0].info.name = "u1";
    file.units[1].info.name = "u2";
    file.limits.units = {{.name = "u1", .continue_when_silent = go_on}, {.name = "u2", .continue_when_silent = go_on}};
  };
}

TEST(ManyUnitsInARun, ContinueWithoutSilentUnit) {
  tests::Bench bench(kHold, make_two_units(true));
  bench.seconds(10);
  bench.instruments().gyro_silent = true;
  EXPECT_EQ(bench.seconds(600), RunOutcome::going_on);
  EXPECT_TRUE(bench.told(EventKind::fault, "gyro u1: "));
  EXPECT_TRUE(bench.told(EventKind::fault, "unit_silent (warn): gyro u1 silent"));
  EXPECT_EQ(bench.count(EventKind::state, ""), 0);
  bench.instruments().gyro_silent = false;
  bench.seconds(20);
  EXPECT_TRUE(bench.told(EventKind::recovered, "gyro u1 answers again"));
}

TEST(ManyUnitsInARun, StateWhyUnitThatSendsIsUnreadable) {
  for (const bool go_on : {true, false}) {
    tests::Bench bench(kHold, make_two_units(go_on));
    bench.seconds(10);
    bench.instruments().gyro_garbled = true;
    bench.seconds(20);
    const std::string alarm = go_on ? "unit_silent (warn)" : "gyro_silent (suspend)";
    EXPECT_TRUE(bench.told(go_on ? EventKind::fault : EventKind::interlock,
                           alarm + ": gyro u1 unreadable (no frame in 350 bytes)"));
    EXPECT_FALSE(bench.told(EventKind::fault, "u1 silent"));
  }
}

TEST(ManyUnitsInARun, SuspendForSilentUnitThatRigRequires) {
  tests::Bench bench(kHold, make_two_units(false));
  bench.seconds(10);
  bench.instruments().gyro_silent = true;
  EXPECT_EQ(bench.until(RunState::suspended, 20), 5);
  EXPECT_TRUE(bench.told(EventKind::interlock, "gyro_silent (suspend): gyro u1 silent"));
}

TEST(ManyUnitsInARun, IgnoreEmptyPosition) {
  tests::Bench bench(kHold, [](rig::RigFile& file) {
    make_two_units(false)(file);
    file.identification.unused = {"u1"};
  });
  bench.instruments().gyro_silent = true;
  EXPECT_EQ(bench.seconds(600), RunOutcome::going_on);
  EXPECT_EQ(bench.count(EventKind::state, ""), 0) << "the rig requires u1, but the run does not";
  EXPECT_FALSE(bench.told(EventKind::fault, "gyro u1: "));
  const auto answer = bench.run_controller().carry_out({.unit = return_unit("u1")}, "ada");
  EXPECT_FALSE(answer.done);
  EXPECT_EQ(answer.text.find("the position u1 is empty in this run") != std::string::npos, true) << answer.text;
}

TEST(ManyUnitsInARun, DropAndReturnUnitOnRequest) {
  tests::Bench bench(kHold, make_two_units(false));
  bench.seconds(10);
  bench.instruments().gyro_silent = true;
  bench.until(RunState::suspended, 20);
  EXPECT_TRUE(bench.run_controller().carry_out({.note = "its fan is loose", .unit = drop("u1")}, "ada").done);
  EXPECT_EQ(bench.until(RunState::execute, 60) > 0, true) << "its silence is no longer a cause";
  EXPECT_TRUE(bench.told(EventKind::dropped, "u1 dropped by ada: its fan is loose"));
  EXPECT_FALSE(bench.told(EventKind::recovered, "gyro u1 answers again")) << "it does not";
  EXPECT_FALSE(bench.run_controller().carry_out({.unit = drop("u2")}, "ada").done) << "the last one";
  bench.seconds(1);
  EXPECT_TRUE(bench.told(EventKind::command, "ada: drop u2, refused: u2 is the only unit left"));
  bench.instruments().gyro_silent = false;
  bench.seconds(10);
  EXPECT_TRUE(bench.run_controller().last().units[0].count.value->pulses.empty())
      << "it sends, and its frames are ignored";
  EXPECT_TRUE(bench.run_controller().carry_out({.unit = return_unit("u1")}, "ada").done);
  bench.seconds(2);
  EXPECT_EQ(bench.run_controller().last().units[0].count.value->pulses, std::vector<std::int64_t>{106});
  EXPECT_TRUE(bench.told(EventKind::recovered, "gyro u1 answers again"));
}

}  // namespace
}  // namespace gyrotherm::run
