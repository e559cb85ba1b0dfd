// SPDX-License-Identifier: Apache-2.0
/// The summary at the end of a run.
#include "sequencer/run/run_tally.hpp"

#include <gtest/gtest.h>

#include "acquisition/record/record.hpp"
#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

TEST(RunTally, CountsFaultsAlarmsSuspendedTimeAndGaps) {
  tests::Bench bench("[[segment]]\nkind = \"hold\"\nat = \"20 °C\"\ntime = \"2 h\"\n");
  bench.seconds(5);
  EXPECT_EQ(describe(bench.run_controller().tally(), bench.record().alarms().count()),
            "0 faulty readings, 0 alarms, 0 s suspended, 0 s held, 0 gaps");
  for (int i = 0; i < 2; ++i) {
    bench.chamber().door_open = true;
    bench.seconds(30);
    bench.chamber().door_open = false;
    bench.seconds(200);
  }
  bench.instruments().gyro_silent = true;
  bench.seconds(4);
  bench.instruments().gyro_silent = false;
  bench.late(3);
  bench.seconds(1);
  bench.late(1);
  bench.seconds(1);
  const auto& tally = bench.run_controller().tally();
  EXPECT_EQ(tally.faulty_readings, 4);
  EXPECT_EQ(tally.gaps, 2);
  EXPECT_EQ(tally.gap_s, 4);
  EXPECT_EQ(tally.gap_s, bench.record().gap_seconds);
  std::int64_t suspended = 0;
  for (const auto& sample : bench.record().samples) suspended += sample.state == RunState::suspended ? 1 : 0;
  EXPECT_EQ(tally.suspended_s, suspended);
  EXPECT_GE(tally.suspended_s, 60);
  const auto words = describe(tally, bench.record().alarms().count());
  EXPECT_NE(words.find("4 faulty readings, 2 alarms of 1 kind (1 unacknowledged), "), std::string::npos) << words;
  EXPECT_NE(words.find("2 gaps of 4 s in all"), std::string::npos) << words;
}

TEST(RunTally, ContinuesFromRecordOfResumedRun) {
  record::Record record;
  record.state = {RunState::execute, RunState::suspended, RunState::suspended, RunState::held};
  record.gaps = {{.first = 4, .last = 9, .cause = "late"}, {.first = 20, .last = 20, .cause = "late"}};
  const auto tally = count_tally(record, 17, 5);
  EXPECT_EQ(
      tally,
      (RunTally{.faulty_readings = 12, .readings_while_off = 5, .suspended_s = 2, .held_s = 1, .gaps = 2, .gap_s = 7}));
  EXPECT_EQ(describe_faults(1, 0), "1 faulty reading");
  EXPECT_EQ(describe_faults(12, 5), "12 faulty readings, 5 missing while a unit was off");
}

}  // namespace
}  // namespace gyrotherm::run
