// SPDX-License-Identifier: Apache-2.0
/// A profile with a prompt waits for an operator, and the record contains the answer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sequencer/run/run_controller.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

const std::string kSwitched = GYROTHERM_SOURCE_DIR "/tests/profiles/switched.toml";

/// A virtual rig that claims to be real, so the run waits for an operator. The test changes the state of the units.
class RealLookingRig final : public rig::Rig {
 public:
  explicit RealLookingRig(rig::Rig& inner) : inner_(inner), file_(inner.file()) { file_.simulated = false; }

  std::vector<Result<std::string>> query_instruments() override { return inner_.query_instruments(); }
  Result<drivers::SetPointRange> controller_limits() override { return inner_.controller_limits(); }
  Result<std::vector<std::string>> prepare(const rig::Entrance& entrance,
                                           const drivers::ChamberProgram* program) override {
    return inner_.prepare(entrance, program);
  }
  bool is_as_found() const override { return inner_.is_as_found(); }
  Duration will_start_utc() const override { return inner_.will_start_utc(); }
  void let_pass(std::int64_t seconds) override { inner_.let_pass(seconds); }
  void set_unit_state(const UnitState&) override {}
  const Clock& clock() const override { return inner_.clock(); }
  io::InstrumentIo& io() override { return inner_.io(); }
  const rig::RigFile& file() const override { return file_; }

 private:
  rig::Rig& inner_;
  rig::RigFile file_;
};

std::vector<std::string> event_texts(const std::string& path, EventKind kind) {
  std::vector<std::string> texts;
  const auto record = record::read_record(path).value();
  for (const auto& recorded : record.events)
    if (recorded.event.kind == kind) texts.push_back(recorded.event.text);
  return texts;
}

/// A run of the profile on a rig that claims to be real.
class PromptTest : public testing::Test {
 protected:
  PromptTest() {
    auto assembled = rig::Rig::assemble(dry_run_.file(), {.seed = {}, .elapsed = {}, .replay = {}});
    EXPECT_TRUE(assembled) << text(assembled.error());
    virtual_rig_ = std::move(*assembled);
    EXPECT_TRUE(virtual_rig_->prepare(Celsius{20}));
    auto created = record::Store::create(dry_run_.path(), dry_run_.info());
    EXPECT_TRUE(created) << text(created.error());
    store_ = std::move(*created);
    rig_ = std::make_unique<RealLookingRig>(*virtual_rig_);
    harness_ = std::make_unique<tests::RunHarness>(dry_run_.profile(), *rig_, *store_);
  }

  /// Brings the units to a state, as an operator does.
  void set_unit_state(const UnitState& state) { virtual_rig_->set_unit_state(state); }
  RunController& run() { return harness_->run_controller(); }
  RunState after(int seconds) {
    harness_->seconds(seconds);
    return run().run_state();
  }
  void answer(const std::string& words) {
    const auto request = control::make_request("resume", words);
    ASSERT_TRUE(request) << text(request.error());
    EXPECT_TRUE(run().carry_out(*request, "ada (uid 1000)").done);
  }

  tests::DryRun dry_run_{kSwitched};
  std::unique_ptr<rig::Rig> virtual_rig_;
  std::unique_ptr<record::Store> store_;
  std::unique_ptr<RealLookingRig> rig_;
  std::unique_ptr<tests::RunHarness> harness_;
};

TEST_F(PromptTest, HoldsRunUntilOperatorAnswers) {
  ASSERT_EQ(after(60), RunState::execute);
  ASSERT_EQ(after(1), RunState::held);
  EXPECT_EQ(run().overview().cause, "the profile asks: switch the unit off");
  EXPECT_EQ(after(3600), RunState::held) << "without a time limit";
  EXPECT_EQ(harness_->progress().segment, 1);
  EXPECT_EQ(harness_->progress().in_segment, Duration{}) << "the profile's clock is stopped";
  set_unit_state({.off = true});
  answer("switched off at the supply");
  ASSERT_EQ(after(1), RunState::execute);
  EXPECT_EQ(after(599), RunState::execute) << "one prompt, and the unit's silence is not a fault";
  ASSERT_EQ(after(1), RunState::held);
  EXPECT_EQ(run().overview().cause, "the profile asks: switch the unit on");
  EXPECT_EQ(after(3600), RunState::held) << "still silent";
  set_unit_state({});
  answer("");
  harness_->seconds(1000);
  ASSERT_EQ(harness_->outcome(), RunOutcome::complete);
  ASSERT_TRUE(store_->finish());
  const auto commands = event_texts(dry_run_.path(), EventKind::command);
  EXPECT_EQ(commands, (std::vector<std::string>{"resume by ada (uid 1000): switched off at the supply",
                                                "resume by ada (uid 1000)"}));
  EXPECT_EQ(event_texts(dry_run_.path(), EventKind::fault), std::vector<std::string>{});
}

TEST_F(PromptTest, SuspendsRunWhenUnitRemainsSilentAfterSwitchOn) {
  ASSERT_EQ(after(61), RunState::held);
  set_unit_state({.off = true});
  answer("");
  ASSERT_EQ(after(601), RunState::held);
  answer("it is on, says somebody who has not looked");
  EXPECT_EQ(after(120), RunState::suspended);
  EXPECT_NE(run().overview().cause.find("gyro silent"), std::string::npos) << run().overview().cause;
}

TEST_F(PromptTest, HasLowerPriorityThanInterlocks) {
  ASSERT_EQ(after(61), RunState::held);
  const auto abort = control::make_request("abort", "");
  ASSERT_TRUE(abort);
  EXPECT_TRUE(run().carry_out(*abort, "ada (uid 1000)").done);
  after(310);  // air watched for 5 min
  EXPECT_EQ(harness_->outcome(), RunOutcome::made_safe);
}

TEST_F(PromptTest, FollowsPauseInItsFirstSecond) {
  ASSERT_EQ(after(60), RunState::execute);
  EXPECT_TRUE(run().carry_out(*control::make_request("pause", ""), "ada (uid 1000)").done);
  ASSERT_EQ(after(1), RunState::held);
  EXPECT_EQ(run().overview().cause, "paused by ada (uid 1000)");
  answer("");
  EXPECT_EQ(after(1), RunState::held);
  EXPECT_EQ(run().overview().cause, "the profile asks: switch the unit off");
  EXPECT_EQ(harness_->progress().in_segment, Duration{});
  answer("");
  EXPECT_EQ(after(1), RunState::execute);
}

TEST(PromptOnTheVirtualRig, IsAnsweredImmediatelyAndRecorded) {
  tests::DryRun dry_run(kSwitched);
  ASSERT_EQ(dry_run.run(), RunOutcome::complete);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_EQ(record->slot.size(), 720u) << "the run does not wait for an operator";
  EXPECT_EQ(event_texts(dry_run.path(), EventKind::note),
            (std::vector<std::string>{"the profile asks: switch the unit off; done by the virtual rig",
                                      "the profile asks: switch the unit on; done by the virtual rig"}));
  EXPECT_FALSE(std::isnan(record->units[0].rotation[0][60])) << "switched off in this second";
  for (std::size_t i = 62; i < 661; ++i) ASSERT_TRUE(std::isnan(record->units[0].rotation[0][i])) << i;
  for (std::size_t i = 663; i < 720; ++i) ASSERT_FALSE(std::isnan(record->units[0].rotation[0][i])) << i;
  EXPECT_EQ(record->info.segments[1].prompt, "switch the unit off");
  EXPECT_TRUE(record->info.segments[1].unit.off);
  EXPECT_FALSE(record->info.segments[2].unit.off);
}

/// The resume replays the time while the unit was off: its temperature and its silence are the same.
TEST(PromptOnTheVirtualRig, IsReplayedWhenRunIsResumed) {
  tests::DryRun dry_run(kSwitched);
  ASSERT_EQ(dry_run.run(), RunOutcome::complete);
  const auto whole = record::read_record(dry_run.path()).value();
  std::filesystem::remove(dry_run.path());
  ASSERT_EQ(dry_run.run(400), RunOutcome::going_on);
  const auto on = plan_continuation(record::read_record(dry_run.path()).value(), dry_run.path(), kSecond, 0);
  ASSERT_TRUE(on) << text(on.error());
  EXPECT_TRUE(on->start.units_may_be_off);
  auto rig = rig::Rig::assemble(on->rig, on->start);
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_TRUE((*rig)->prepare(Celsius{20}));
  (*rig)->let_pass(1);
  const auto sample = (*rig)->io().read(0, (*rig)->clock());
  EXPECT_FALSE(sample.units[0].count.value);
  const auto slot = static_cast<std::size_t>(on->start.elapsed / std::chrono::seconds(1));
  ASSERT_TRUE(sample.thermometers[0].value);
  EXPECT_EQ(sample.thermometers[0].value->value, whole.thermometers_c[0][slot]);
  EXPECT_LT(whole.thermometers_c[0][slot], whole.thermometers_c[0][60] - 0.1) << "it cools without its power";
}

}  // namespace
}  // namespace gyrotherm::run
