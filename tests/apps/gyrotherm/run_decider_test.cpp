// SPDX-License-Identifier: Apache-2.0
/// The decisions of a run on a bench, computed in the tick and in a thread of their own. The gyro of the bench has a
/// constant count, so no model can be fitted. With a broken prior, nothing can be computed.
#include "apps/gyrotherm/run/run_decider.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "core/file.hpp"
#include "tests/support/bench_rig.hpp"

namespace gyrotherm::app {
namespace {

const std::string kBenchProfile =
    "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"10 min\"\n[until]\nu_deg_per_h = 0.01\nmission = \"m\"\n"
    "longest = \"2 h\"\n[[until.block]]\nname = \"hot\"\n[[until.block.segment]]\nkind = \"ramp\"\nto = 30\nrate = 5\n"
    "[[until.block.segment]]\nkind = \"hold\"\ntime = \"10 min\"\n";

record::Record empty_history() {
  record::Record history;
  history.info.goal = {
      .u_deg_per_h = 0.01,
      .mission_name = "m",
      .mission_text = read_text_file(GYROTHERM_SOURCE_DIR "/tests/profiles/short-mission.toml").value_or("")};
  for (const char name : std::string("ABCDEFGHI"))
    history.info.thermometers.push_back({std::string(1, name), "a bridge", Kelvins{0}});
  history.info.units = {{.axes = {{.scale = 0.1, .earth_rate = DegreesPerHour{10}}}, .gradients = {"A", "B"}}};
  history.info.segments = {{"hold 20 °C", true, Celsius{20}, {}, -1}};
  return history;
}

record::Record history_with_broken_prior() {
  auto history = empty_history();
  history.info.goal->prior_text = "{";
  return history;
}

struct QuietConsole : Console {
  QuietConsole() { quiet = true; }
};

/// Runs until a decision has been carried out. Returns the number of seconds.
int run_until_decided(tests::Bench& bench, RunDecider& decider, Console& console) {
  int count = 0;
  for (; bench.run_controller().profile().added_blocks.empty() && count < 100'000; ++count) {
    if (bench.run_controller().awaits_decision()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(bench.seconds(1), run::RunOutcome::going_on);
    EXPECT_TRUE(decider.after_tick(bench.run_controller(), console));
  }
  return count;
}

std::string decision_text(const tests::Bench& bench, tests::BenchStore& store) {
  EXPECT_EQ(bench.count(EventKind::note, "decision 1: "), 1);
  for (const auto& event : store.events)
    if (record::is_decision(event)) return event.text;
  return "";
}

TEST(RunDecider, EndsRunWhoseUncertaintyCannotBeComputed) {
  for (const bool in_worker : {false, true}) {
    SCOPED_TRACE(in_worker);
    tests::Bench bench(kBenchProfile);
    QuietConsole console;
    const auto decider = RunDecider::make(history_with_broken_prior(), in_worker).value();
    EXPECT_NE(decider->describe_progress(0).find("0.01 °/h wanted"), std::string::npos);
    const auto count = run_until_decided(bench, *decider, console);
    EXPECT_GE(count, 400) << "in the last two clusters of the hold";
    EXPECT_TRUE(in_worker || count == 400) << "without a thread, in the second in which it is due: " << count;
    const auto text = decision_text(bench, bench.record());
    EXPECT_NE(text.find("end, U cannot be met; U unknown now, 0.01 °/h wanted"), std::string::npos) << text;
    EXPECT_EQ(bench.seconds(1000), run::RunOutcome::complete) << "without closing segments";
    EXPECT_EQ(bench.count(EventKind::fault, "the uncertainty cannot be computed: gyro: "), 1);
    EXPECT_NE(decider->describe_progress(0).find("the run ends: U cannot be met"), std::string::npos);
  }
}

TEST(RunDecider, TakesFirstBlockWhileRecordIsShort) {
  tests::Bench bench(kBenchProfile);
  QuietConsole console;
  const auto decider = RunDecider::make(empty_history(), false).value();
  (void)run_until_decided(bench, *decider, console);
  const auto text = decision_text(bench, bench.record());
  EXPECT_NE(text.find("continue with \"hot\"; U unknown now, unknown expected"), std::string::npos) << text;
  EXPECT_EQ(bench.count(EventKind::fault, "the uncertainty cannot be computed"), 0);
}

/// Records `rows` seconds of the bench's gyro, then 200 s without a reading.
record::Record history_with_silence(int rows) {
  auto history = empty_history();
  for (int slot = 0; slot < rows + 200; ++slot) {
    const Instant at{kSecond * slot, {}};
    Sample sample;
    sample.slot = slot;
    sample.at = at;
    sample.chamber = {ChamberState{Celsius{20}, Celsius{20}}, at};
    sample.thermometers.assign(9, {Celsius{20}, at});
    sample.units = {{.count = {GyroCount{{106}, kSecond}, at}}};
    if (slot >= rows) sample.units[0].count.value = failure(FaultKind::timeout, "gyro", "silent");
    record::append_sample(history, sample);
  }
  return history;
}

TEST(AssessedRun, LeavesOutAxisThatHasFallenSilent) {
  const auto mission = mission_path(*empty_history().info.goal).value();
  const auto silent = assess_run(history_with_silence(500), mission, {mission, mission});
  EXPECT_EQ(silent.trouble, "no axis has a reading in the last 200 s");
  EXPECT_TRUE(std::isinf(silent.u_now_deg_per_h));
  ASSERT_EQ(silent.u_after_deg_per_h.size(), 2U);
  EXPECT_TRUE(std::isinf(silent.u_after_deg_per_h[1]));
  auto alive = history_with_silence(500);
  alive.units[0].rotation[0].back() = 106;
  alive.info.goal->prior_text = "{";
  EXPECT_NE(assess_run(alive, mission, {}).trouble.find("gyro: "), std::string::npos) << "it is assessed";
  auto unused = history_with_silence(500);
  unused.info.unused_units = {record::kOnlyUnit};
  EXPECT_NE(assess_run(unused, mission, {}).trouble, "");
}

TEST(RunDecider, ContinuesNumbersOfResumedRun) {
  auto history = empty_history();
  const auto earlier =
      record::decision_event({.number = 7, .block = "hot", .target_deg_per_h = 0.01, .blocks = {}}, {}, 1);
  history.events.push_back({.slot = 3, .event = earlier});
  tests::Bench bench(kBenchProfile);
  QuietConsole console;
  const auto decider = RunDecider::make(std::move(history), false).value();
  EXPECT_NE(decider->describe_progress(0).find("expected after \"hot\""), std::string::npos);
  (void)run_until_decided(bench, *decider, console);
  EXPECT_EQ(bench.count(EventKind::note, "decision 8: "), 1);
}

TEST(RunDecider, StopsComputationWhenRunIsAborted) {
  tests::Bench bench(kBenchProfile);
  QuietConsole console;
  auto decider = RunDecider::make(empty_history(), true).value();
  for (int i = 0; i < 401; ++i) {
    bench.seconds(1);
    ASSERT_TRUE(decider->after_tick(bench.run_controller(), console));
  }
  ASSERT_TRUE(
      bench.run_controller().carry_out({.command = control::OperatorCommand::abort, .note = "test"}, "ada").done);
  const auto before = bench.run_controller().profile().added_blocks;  // a fast machine has added the first one
  for (int i = 0; i < 50 && bench.seconds(1) == run::RunOutcome::going_on; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ASSERT_TRUE(decider->after_tick(bench.run_controller(), console));
  }
  EXPECT_EQ(bench.run_controller().profile().added_blocks, before) << "its result is not used";
  decider.reset();
}

TEST(RunDecider, IsAbsentForFixedEndAndRefusesBrokenMission) {
  EXPECT_EQ(RunDecider::make({}, false).value(), nullptr);
  auto history = empty_history();
  history.info.goal->mission_text = "schema = 1";
  EXPECT_FALSE(RunDecider::make(std::move(history), false));
}

TEST(ProgramPath, HasMeansAndPowerOnsOfClusters) {
  const std::vector<profile::Segment> segments{
      {.kind = profile::SegmentKind::ramp, .name = {}, .target = {30}, .duration = std::chrono::seconds(200)},
      {.kind = profile::SegmentKind::hold,
       .name = {},
       .target = {30},
       .duration = std::chrono::seconds(150),
       .unit = {.off = true}},
      {.kind = profile::SegmentKind::hold, .name = {}, .target = {30}, .duration = std::chrono::seconds(199)}};
  const auto path = program_path(segments, {10});
  ASSERT_EQ(path.set_point_c.size(), 5) << "the part of a cluster at the end is omitted";
  EXPECT_NEAR(path.set_point_c(0), 15, 0.06);
  EXPECT_NEAR(path.set_point_c(1), 25, 0.06);
  EXPECT_NEAR(path.set_point_c(4), 30, 1e-9);
  EXPECT_EQ(path.start(0), 0);
  EXPECT_EQ(path.start(2), -1);
  EXPECT_EQ(path.start(3), -1) << "partly off";
  EXPECT_EQ(path.start(4), 1);
  EXPECT_EQ(program_path({}, {20}).set_point_c.size(), 0);
  const auto mission = mission_path(*empty_history().info.goal);
  ASSERT_TRUE(mission) << text(mission.error());
  EXPECT_EQ(mission->set_point_c.size(), (30 + 20 + 30) * 60 / 100);
}

/// Returns a hold of one cluster.
profile::Segment one_cluster(bool off) {
  return {.kind = profile::SegmentKind::hold,
          .name = {},
          .target = {30},
          .duration = std::chrono::seconds(100),
          .unit = {.off = off}};
}

TEST(ProgramPath, CountsNoPowerOnBeforeFirstSegmentWithUnitOn) {
  const std::vector begins_off{one_cluster(true), one_cluster(true), one_cluster(false), one_cluster(true),
                               one_cluster(false)};
  const auto block = program_path(begins_off, {30});
  EXPECT_EQ(block.start, (Eigen::VectorXi(5) << -1, -1, 0, -1, 1).finished());
  const std::vector on{one_cluster(false)};
  const auto joined = join(program_path(on, {30}), block);
  EXPECT_EQ(joined.start, (Eigen::VectorXi(6) << 0, -1, -1, 1, -1, 2).finished());
  EXPECT_EQ(planning::count_starts(joined), 3);
  EXPECT_EQ(planning::count_starts(program_path(std::vector{one_cluster(true)}, {30})), 0);
}

}  // namespace
}  // namespace gyrotherm::app
