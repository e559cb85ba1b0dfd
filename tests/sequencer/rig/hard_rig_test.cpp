// SPDX-License-Identifier: Apache-2.0
/// Runs on the hard rig: the record contains the true bias, and --days-later ages the gyro.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/dry_run.hpp"

namespace gyrotherm::rig {
namespace {

constexpr const char* kShortRandom = GYROTHERM_SOURCE_DIR "/tests/profiles/short-random.toml";

record::Record record_seconds(tests::DryRun& dry_run, std::int64_t seconds) {
  (void)dry_run.run(seconds);
  auto record = record::read_record(dry_run.path());
  EXPECT_TRUE(record) << text(record.error());
  return std::move(*record);
}

/// The reading of each second scatters around Earth rate plus true bias: 0.018 °/h in one second.
TEST(HardRig, RecordsTrueBiasOfEachSecond) {
  tests::DryRun dry_run(kShortRandom, 3, "virtual-hard");
  const auto record = record_seconds(dry_run, 1'000'000);
  ASSERT_TRUE(record.finished);
  ASSERT_EQ(record.units[0].true_bias_deg_per_h[0].size(), record.slot.size());
  double error = 0;
  for (std::size_t i = 0; i < record.slot.size(); ++i) {
    ASSERT_TRUE(std::isfinite(record.units[0].true_bias_deg_per_h[0][i])) << i;
    const double rate = 0.1 * record.units[0].rotation[0][i] / record.units[0].interval_s[i];
    error += (rate - record.info.units[0].axes[0].earth_rate->value - record.units[0].true_bias_deg_per_h[0][i]) /
             static_cast<double>(record.slot.size());
  }
  EXPECT_NEAR(error, 0, 0.008) << "without turn-on bias, scale factor and tilt";
}

TEST(HardRig, LaterDayIsNewRunOfOlderGyro) {
  tests::DryRun now(kShortRandom, 3, "virtual-hard");
  const auto before = record_seconds(now, 300);
  tests::DryRun later(kShortRandom, 3, "virtual-hard");
  later.days_later = 365;
  EXPECT_NE(later.info().id, now.info().id);
  std::filesystem::remove(now.path());
  const auto after = record_seconds(later, 300);
  EXPECT_EQ(after.info.days_later, 365u);
  EXPECT_NE(after.units[0].true_bias_deg_per_h[0].back(), before.units[0].true_bias_deg_per_h[0].back());
  EXPECT_NEAR(after.units[0].true_bias_deg_per_h[0].back(), before.units[0].true_bias_deg_per_h[0].back(), 0.02)
      << "the same gyro";
}

/// The virtual laboratory of a resumed run is bit-identical to that of the interrupted run.
TEST(HardRig, ResumeReplaysSameDays) {
  tests::DryRun dry_run(kShortRandom, 3, "virtual-hard");
  dry_run.days_later = 30;
  const auto whole = record_seconds(dry_run, 200);
  std::filesystem::remove(dry_run.path());
  const auto interrupted = record_seconds(dry_run, 150);
  ASSERT_EQ(interrupted.units[0].true_bias_deg_per_h[0].back(), whole.units[0].true_bias_deg_per_h[0][149]);
  const auto on = run::plan_continuation(interrupted, dry_run.path(), kSecond, 0);
  ASSERT_TRUE(on) << text(on.error());
  EXPECT_EQ(on->start.seed.days_later, 30u);
  const auto next_after = [](const run::RunContinuation& continuation) {
    auto rig = Rig::assemble(continuation.rig, continuation.start);
    EXPECT_TRUE(rig) << text(rig.error());
    EXPECT_TRUE((*rig)->prepare(demanded_set_point(continuation.profile, continuation.state)));
    (*rig)->let_pass(1);
    return (*rig)->io().read(0, (*rig)->clock());
  };
  const auto sample = next_after(*on);
  const auto slot = static_cast<std::size_t>(on->start.elapsed / std::chrono::seconds(1));
  ASSERT_FALSE(sample.units[0].true_bias.empty());
  EXPECT_EQ(sample.units[0].true_bias[0].value, whole.units[0].true_bias_deg_per_h[0][slot]);
  EXPECT_EQ(sample.thermometers[0].value->value, whole.thermometers_c[0][slot]);
  EXPECT_EQ(static_cast<double>(sample.units[0].count.value->pulses[0]), whole.units[0].rotation[0][slot]);
  auto on_day_0 = *on;
  on_day_0.start.seed.days_later = 0;
  EXPECT_NE(next_after(on_day_0).units[0].true_bias[0].value, sample.units[0].true_bias[0].value);
}

TEST(HardRig, ColdStartBeginsAtStartOfProfile) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/profiles/cold-start.toml", 0, "virtual-hard");
  const auto record = record_seconds(dry_run, 60);
  EXPECT_NEAR(record.chamber_air_c.front(), -40, 0.1);
  EXPECT_NEAR(record.thermometers_c[0].front(), -40, 0.1);
}

}  // namespace
}  // namespace gyrotherm::rig
