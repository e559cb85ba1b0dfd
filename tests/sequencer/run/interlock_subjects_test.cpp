// SPDX-License-Identifier: Apache-2.0
/// An alarm is identified by its interlock and its subject: a second culprit has an event and an alarm of its own.
#include <gtest/gtest.h>

#include "tests/sequencer/run/interlock_bench.hpp"
#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

using Strings = std::vector<std::string>;

/// Returns nine thermometers on two instruments, as on the virtual rig.
InterlockBench nine_thermometers() {
  InterlockBench bench;
  bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  bench.limits.instruments = {{.name = "thermometer 1", .columns = {0, 1, 2, 3, 4, 5, 6, 7}},
                              {.name = "thermometer 2", .columns = {8}}};
  bench.limits.thermometers_fastest = {1e5};  // readings of these tests jump
  return bench;
}

TEST(InterlockSubjects, RaiseAlarmForSecondThermometerThatDisagrees) {
  auto bench = nine_thermometers();
  bench.limits.disagreement = {10};
  bench.thermometer(2, 40);
  bench.seconds(100);
  EXPECT_EQ(bench.raised, Strings{"disagreement C"});
  bench.thermometer(2, 22);
  bench.thermometer(0, -5);
  bench.seconds(90);
  EXPECT_EQ(bench.raised, (Strings{"disagreement C", "disagreement A"}));
  EXPECT_EQ(bench.cleared, Strings{"disagreement C"});
}

TEST(InterlockSubjects, RaiseAlarmForEachOfTwoThermometersThatDisagreeTogether) {
  auto bench = nine_thermometers();
  bench.limits.disagreement = {10};
  bench.thermometer(2, 40);
  bench.seconds(70);
  bench.thermometer(0, 35);
  bench.seconds(70);
  EXPECT_EQ(bench.raised, (Strings{"disagreement C", "disagreement A"}));
  EXPECT_EQ(active_faults(bench.memory).size(), 2U);
}

TEST(InterlockSubjects, RaiseAlarmForGuardWhileSafeStateFileIsMissing) {
  InterlockBench bench;
  bench.around.guard_troubles = {{"safe-state file", "the safe-state file is gone"}};
  bench.seconds(30);
  bench.around.guard_troubles["guard"] = "the guard has ended";
  bench.seconds(30);
  EXPECT_EQ(bench.raised, (Strings{"unguarded safe-state file", "unguarded guard"}));
  bench.around.guard_troubles.erase("safe-state file");
  bench.seconds(30);
  EXPECT_EQ(bench.cleared, Strings{"unguarded safe-state file"});
  EXPECT_EQ(bench.alarms, 2);
}

TEST(InterlockSubjects, RaiseAlarmForChannelLostAfterAnother) {
  auto bench = nine_thermometers();
  bench.sample.thermometers[1].value = silence();
  bench.seconds(5);
  bench.sample.thermometers[8].value = silence();
  bench.seconds(5);
  EXPECT_EQ(bench.raised, (Strings{"channel_lost B", "channel_lost shell"}));
}

TEST(InterlockSubjects, RaiseOneAlarmForAllChannelsOfSilentInstrument) {
  auto bench = nine_thermometers();
  bench.sample.thermometers[1].value = silence();
  bench.seconds(5);
  for (std::size_t i = 0; i < 8; ++i) bench.sample.thermometers[i].value = silence();
  bench.seconds(5);
  EXPECT_EQ(bench.raised, (Strings{"channel_lost B", "channel_lost thermometer 1"}));
  EXPECT_TRUE(bench.cleared.empty()) << "B is lost nevertheless";
}

TEST(InterlockSubjects, RaiseAlarmForUnitThatFallsSilentAfterAnother) {
  InterlockBench bench;
  bench.limits.units = {{.name = "u1"}, {.name = "u2"}, {.name = "u3"}};
  bench.sample.units.assign(3, bench.sample.units.front());
  bench.sample.units[0].count.value = silence();
  bench.seconds(20);
  bench.sample.units[2].count.value = silence();
  bench.seconds(20);
  EXPECT_EQ(bench.raised, (Strings{"gyro_silent u1", "gyro_silent u3"}));
}

TEST(InterlockSubjects, RaiseAlarmForThermometerThatStopsAfterAnother) {
  auto bench = nine_thermometers();
  for (int i = 0; i < 600; ++i) {
    for (std::size_t t = 0; t < 9; ++t)
      if (t != 4 && (t != 5 || i < 300)) bench.thermometer(t, 22 + 0.02 * i);
    bench.second();
  }
  EXPECT_EQ(bench.raised, (Strings{"stuck E", "stuck F"}));
}

/// Tests the fields of the record's events.
TEST(InterlockSubjects, AreChannelsOfEvents) {
  tests::Bench bench("[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"1 h\"\n");
  bench.seconds(5);
  bench.run_controller().set_guard_troubles({{"safe-state file", "the safe-state file is gone"}});
  bench.seconds(5);
  bench.run_controller().set_guard_troubles({{"guard", "the guard has ended"}});
  bench.seconds(20);
  Strings told;
  for (const auto& event : bench.record().events)
    if (event.about.interlock == "unguarded") told.push_back(std::string(name(event.kind)) + " " + event.about.channel);
  EXPECT_EQ(told, (Strings{"fault safe-state file", "fault guard", "recovered safe-state file"}));
}

}  // namespace
}  // namespace gyrotherm::run
