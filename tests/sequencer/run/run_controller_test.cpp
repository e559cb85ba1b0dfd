// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/run_controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "sequencer/profile/profile.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

const std::string kShort = GYROTHERM_SOURCE_DIR "/tests/profiles/short-rate.toml";

TEST(RunController, RecordsOneSamplePerSecondOfProfile) {
  tests::DryRun dry_run(kShort);
  ASSERT_EQ(dry_run.run(), RunOutcome::complete);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  const auto planned = plan(dry_run.profile()).all;
  EXPECT_EQ(static_cast<std::int64_t>(record->slot.size()), (planned.ramps + planned.holds) / std::chrono::seconds(1));
  for (std::size_t i = 0; i < record->slot.size(); ++i) ASSERT_EQ(record->slot[i], static_cast<std::int64_t>(i));
  EXPECT_TRUE(record->finished);
  EXPECT_TRUE(record->gaps.empty());
}

TEST(RunController, ReadsVirtualRigWithoutFaults) {
  tests::DryRun dry_run(kShort);
  dry_run.run(3000);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  for (std::size_t i = 0; i < record->slot.size(); ++i) {
    ASSERT_FALSE(std::isnan(record->chamber_air_c[i])) << i;
    ASSERT_FALSE(std::isnan(record->units[0].rotation[0][i])) << i;
    ASSERT_NEAR(record->units[0].interval_s[i], 1.0, 1e-3) << i;
    for (const auto& channel : record->thermometers_c) ASSERT_FALSE(std::isnan(channel[i])) << i;
  }
}

TEST(RunController, SendsSetPointOfProfileEachSecond) {
  tests::DryRun dry_run(kShort);
  dry_run.run(4000);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  for (std::size_t i = 0; i < record->slot.size(); ++i)
    ASSERT_NEAR(record->chamber_set_point_c[i], record->set_point_c[i], 1e-5) << "second " << i;
}

TEST(RunController, MakesChamberSafeWhenUnitExceedsLimit) {
  tests::DryRun dry_run(kShort);
  dry_run.file().limits.thermometers_lowest = {10};
  EXPECT_EQ(dry_run.run(), RunOutcome::made_safe);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_FALSE(record->finished);
  const auto& events = record->events;
  const auto interlock =
      std::find_if(events.begin(), events.end(), [](const auto& e) { return e.event.kind == EventKind::interlock; });
  ASSERT_NE(interlock, events.end());
  EXPECT_NE(std::find_if(events.begin(), events.end(),
                         [](const auto& e) { return e.event.text.find("was sent to 20 °C") != std::string::npos; }),
            events.end());
}

TEST(Rig, SendsOnlyPermittedCommands) {
  tests::DryRun dry_run(kShort);
  auto rig = rig::Rig::assemble(dry_run.file(), {.seed = {}, .elapsed = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  std::optional<ChamberState> before;
  const auto refuse = [&](const rig::FoundChamber& now) -> Result<Celsius> {
    before = now.state;
    return failure(FaultKind::interrupted, "chamber", "not now");
  };
  EXPECT_EQ((*rig)->prepare(refuse, nullptr).error().what, "not now");
  ASSERT_TRUE(before);
  EXPECT_NE(before->set_point, Celsius{60});
  const auto asked = (*rig)->query_instruments();
  ASSERT_TRUE(asked.front()) << text(asked.front().error());
  EXPECT_NE(asked.front()->find("set point 20.00 °C"), std::string::npos) << *asked.front();
}

}  // namespace
}  // namespace gyrotherm::run
