// SPDX-License-Identifier: Apache-2.0
/// A run that ends by itself: its decisions, its growth and its resume. The uncertainties are given by the test.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "acquisition/record/chain.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/run/block_choice.hpp"
#include "tests/support/bench_rig.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

const std::string kUntilProfile = GYROTHERM_SOURCE_DIR "/tests/profiles/short-until.toml";

/// Decides with uncertainties that depend only on the number of the decision.
void decide_if_due(RunController& controller) {
  if (!controller.awaits_decision()) return;
  const auto& profile = controller.profile();
  const auto number = profile.added_blocks.size() + 1;
  DecisionInputs inputs{.number = static_cast<int>(number),
                        .target_deg_per_h = 0.02,
                        .u_now_deg_per_h = 0.1 / static_cast<double>(number),
                        .used = kSecond * controller.next_slot(),
                        .hold_left = time_left(profile, controller.state())};
  for (std::size_t i = 0; i < profile.until->blocks.size(); ++i)
    inputs.u_after_deg_per_h.push_back(inputs.u_now_deg_per_h * (number % profile.until->blocks.size() == i ? 0.2 : 1));
  const auto done = controller.carry_out(decide(profile, inputs));
  EXPECT_TRUE(done) << text(done.error());
}

record::RunInfo::Goal goal() { return {.u_deg_per_h = 0.02, .mission_name = "m", .mission_text = "t"}; }

/// A self-ending run on a virtual rig, in lives that each end without warning.
class SelfEndingRun {
 public:
  SelfEndingRun() : dry_run_(kUntilProfile) {}

  [[nodiscard]] std::string path() const { return dry_run_.path(); }

  /// Runs the first life until the condition is true for the controller, or the run ends.
  RunOutcome begin_life(const std::function<bool(const RunController&)>& is_over) {
    auto info = run_info("", dry_run_.profile(), dry_run_.file(), 0, {}, 0, goal());
    auto rig =
        rig::Rig::assemble(dry_run_.file(), {.seed = {}, .elapsed = {}, .replay = {}, .first_set_point = Celsius{20}});
    EXPECT_TRUE((*rig)->prepare(Celsius{20}));
    auto store = record::Store::create(path(), info).value();
    RunController controller(dry_run_.profile(), **rig, *store, profile::begin(dry_run_.profile()), 0);
    return live(controller, **rig, *store, is_over);
  }

  /// Resumes from the record after one second without a program.
  RunOutcome resume_life(const std::function<bool(const RunController&)>& is_over) {
    const auto on = plan_continuation(record::read_record(path()).value(), path(), kSecond, 0);
    EXPECT_TRUE(on) << text(on.error());
    auto rig = rig::Rig::assemble(on->rig, on->start);
    EXPECT_TRUE((*rig)->prepare(demanded_set_point(on->profile, on->state)));
    auto store = record::Store::reopen(path()).value();
    const auto first = (*rig)->clock().now().since_start / kSecond;
    EXPECT_TRUE(store->append_gap(on->recorded + 1, first - 1, "killed"));
    RunController controller(on->profile, **rig, *store, on->state, first);
    return live(controller, **rig, *store, is_over);
  }

 private:
  static RunOutcome live(RunController& controller, rig::Rig& rig, record::Store& store,
                         const std::function<bool(const RunController&)>& is_over) {
    auto outcome = RunOutcome::going_on;
    while (outcome == RunOutcome::going_on && !is_over(controller)) {
      rig.let_pass(1);
      outcome = controller.tick(controller.next_slot()).value();
      if (outcome == RunOutcome::going_on) decide_if_due(controller);
      EXPECT_TRUE(controller.next_slot() % 300 != 0 || store.sync());
    }
    if (outcome == RunOutcome::complete) {
      EXPECT_TRUE(store.finish());
    } else {
      EXPECT_TRUE(store.sync());
    }
    return outcome;
  }

  tests::DryRun dry_run_;
};

bool never(const RunController&) { return false; }

const std::vector<std::string> kPath{"hot", "power-on", "cold", "hot", ""};

TEST(SelfEndingRuns, EndByThemselvesOnRecordedPath) {
  SelfEndingRun run;
  EXPECT_EQ(run.begin_life(never), RunOutcome::complete);
  const auto record = record::read_record(run.path()).value();
  EXPECT_TRUE(record.finished);
  EXPECT_EQ(record.info.added_blocks, kPath);
  std::vector<record::Decision> decisions;
  for (const auto& [slot, event] : record.events)
    if (record::is_decision(event)) decisions.push_back(record::parse_decision(event.text).value());
  ASSERT_EQ(decisions.size(), 5u);
  for (std::size_t i = 0; i < decisions.size(); ++i) {
    EXPECT_EQ(decisions[i].number, static_cast<int>(i) + 1);
    EXPECT_EQ(decisions[i].block, kPath[i]);
  }
  EXPECT_EQ(decisions.back().end, kMet);
  EXPECT_EQ(record.progress.back().segment, static_cast<int>(record.info.segments.size()) - 1);
  EXPECT_EQ(record.info.segments.back().name, "ramp to 20 °C") << "the closing";
  EXPECT_NEAR(record.chamber_air_c.back(), 20, 1);
  EXPECT_EQ(record.gaps.size(), 0u);
  EXPECT_TRUE(record::verify_record(run.path()));
}

TEST(SelfEndingRuns, RebuiltProfileHasRecordedSegments) {
  SelfEndingRun run;
  (void)run.begin_life([](const RunController& controller) { return controller.profile().added_blocks.size() == 3; });
  const auto record = record::read_record(run.path()).value();
  const auto on = plan_continuation(record, run.path(), kSecond, 0).value();
  ASSERT_EQ(on.profile.segments.size(), record.info.segments.size());
  for (std::size_t i = 0; i < on.profile.segments.size(); ++i) {
    EXPECT_EQ(on.profile.segments[i].name, record.info.segments[i].name);
    EXPECT_EQ(on.profile.segments[i].target, record.info.segments[i].target);
    EXPECT_EQ(on.profile.segments[i].unit, record.info.segments[i].unit);
  }
}

/// Kills the program once in each segment, and in the second after each decision.
TEST(SelfEndingRuns, TakeSamePathWhenKilledInEachSegment) {
  SelfEndingRun whole;
  ASSERT_EQ(whole.begin_life(never), RunOutcome::complete);
  const auto expected = record::read_record(whole.path()).value();
  const auto segments = static_cast<int>(expected.info.segments.size());
  ASSERT_EQ(segments, 12);
  std::filesystem::remove_all(whole.path());
  for (int killed_in = 0; killed_in < segments; ++killed_in) {
    SCOPED_TRACE(killed_in);
    SelfEndingRun run;
    const auto is_over = [&](const RunController& controller) {
      const auto at = profile_position(controller.profile(), controller.state());
      return at.segment == killed_in && at.in_segment > std::chrono::seconds(killed_in % 2 == 0 ? 30 : 130);
    };
    ASSERT_EQ(run.begin_life(is_over), RunOutcome::going_on);
    ASSERT_EQ(run.resume_life(never), RunOutcome::complete);
    const auto record = record::read_record(run.path()).value();
    EXPECT_EQ(record.info.added_blocks, kPath);
    EXPECT_EQ(record.info.segments.size(), expected.info.segments.size());
    EXPECT_TRUE(record::verify_record(run.path()));
    std::filesystem::remove_all(run.path());
  }
}

TEST(SelfEndingRuns, TakeSamePathWhenKilledAroundEachDecision) {
  for (std::size_t killed_at = 1; killed_at <= kPath.size(); ++killed_at) {
    SCOPED_TRACE(killed_at);
    SelfEndingRun run;
    ASSERT_EQ(run.begin_life([&](const RunController& controller) {
      return controller.profile().added_blocks.size() == killed_at;
    }),
              RunOutcome::going_on)
        << "just after the decision";
    ASSERT_EQ(run.resume_life(never), RunOutcome::complete);
    EXPECT_EQ(record::read_record(run.path()).value().info.added_blocks, kPath);
  }
}

/// A bench with a short opening and one block.
const std::string kBenchUntil =
    "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"10 min\"\n[until]\nu_deg_per_h = 0.01\nmission = \"m\"\n"
    "longest = \"2 h\"\n[[until.block]]\nname = \"hot\"\n[[until.block.segment]]\nkind = \"ramp\"\nto = 30\nrate = 5\n"
    "[[until.block.segment]]\nkind = \"hold\"\ntime = \"10 min\"\n";

record::Decision choose_hot() { return {.number = 1, .block = "hot", .u_now_deg_per_h = 1, .blocks = {}}; }

TEST(SelfEndingRuns, LastHoldContinuesUntilLateDecision) {
  tests::Bench bench(kBenchUntil);
  bench.seconds(399);
  EXPECT_FALSE(bench.run_controller().awaits_decision());
  bench.seconds(2);
  EXPECT_TRUE(bench.run_controller().awaits_decision()) << "two clusters before the end";
  EXPECT_EQ(bench.seconds(1000), RunOutcome::going_on);
  EXPECT_EQ(bench.progress().segment, 0);
  EXPECT_EQ(bench.progress().in_segment, std::chrono::seconds(599));
  EXPECT_EQ(bench.count(EventKind::note, "the hold continues until the next block has been chosen"), 1) << "once";
  ASSERT_TRUE(bench.run_controller().carry_out(choose_hot()));
  EXPECT_FALSE(bench.run_controller().awaits_decision());
  bench.seconds(2);
  EXPECT_EQ(bench.progress().segment, 1);
  EXPECT_EQ(bench.run_controller().overview().behind_plan, std::chrono::seconds(802));
  ASSERT_EQ(bench.seconds(720), RunOutcome::going_on);
  EXPECT_TRUE(bench.run_controller().awaits_decision()) << "again at the end of the block";
  ASSERT_TRUE(bench.run_controller().carry_out({.number = 2, .end = kMet, .u_now_deg_per_h = 0.01, .blocks = {}}));
  EXPECT_EQ(bench.seconds(1000), RunOutcome::complete);
  EXPECT_EQ(bench.count(EventKind::finished, "profile complete"), 1);
}

TEST(SelfEndingRuns, RefuseWhatIsNotReleased) {
  tests::Bench bench(kBenchUntil);
  bench.seconds(500);
  const auto refused = bench.run_controller().carry_out({.number = 1, .block = "scorching", .blocks = {}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::mismatch);
  EXPECT_EQ(bench.run_controller().profile().segments.size(), 1u);
  EXPECT_EQ(bench.count(EventKind::note, "decision"), 0);
  ASSERT_TRUE(bench.run_controller().carry_out({.number = 1, .end = kMet, .blocks = {}}));
  EXPECT_FALSE(bench.run_controller().carry_out(choose_hot())) << "the run ends";
  EXPECT_EQ(bench.seconds(1000), RunOutcome::complete);
}

TEST(SelfEndingRuns, MakeNoDecisionAfterAbort) {
  tests::Bench bench(kBenchUntil);
  bench.seconds(350);
  ASSERT_TRUE(bench.run_controller().carry_out({.command = OperatorCommand::abort, .note = "test"}, "ada").done);
  bench.seconds(100);
  EXPECT_GE(bench.run_controller().run_state(), RunState::aborting);
  EXPECT_FALSE(bench.run_controller().awaits_decision());
}

TEST(SelfEndingRuns, StopAtLastHoldEndsRun) {
  tests::Bench bench(kBenchUntil);
  bench.seconds(700);
  ASSERT_TRUE(bench.run_controller().carry_out({.command = OperatorCommand::stop, .note = "enough"}, "ada").done);
  bench.seconds(5);
  EXPECT_NE(bench.run_controller().run_state(), RunState::execute) << "an open profile does not keep the run alive";
}

/// While the run is paused, the clock of the last hold stands anyway. A decision may be carried out meanwhile.
TEST(SelfEndingRuns, DecideWhilePaused) {
  tests::Bench bench(kBenchUntil);
  bench.seconds(450);
  ASSERT_TRUE(bench.run_controller().carry_out({.command = OperatorCommand::pause, .note = "look"}, "ada").done);
  bench.seconds(10);
  ASSERT_EQ(bench.run_controller().run_state(), RunState::held);
  EXPECT_TRUE(bench.run_controller().awaits_decision());
  ASSERT_TRUE(bench.run_controller().carry_out(choose_hot()));
  bench.seconds(500);
  EXPECT_EQ(bench.progress().segment, 0) << "still paused";
  EXPECT_EQ(bench.count(EventKind::note, "the hold continues"), 0);
  ASSERT_TRUE(bench.run_controller().carry_out({.command = OperatorCommand::resume, .note = ""}, "ada").done);
  bench.seconds(200);
  EXPECT_EQ(bench.progress().segment, 1);
}

}  // namespace
}  // namespace gyrotherm::run
