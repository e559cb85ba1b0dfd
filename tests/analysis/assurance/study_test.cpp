// SPDX-License-Identifier: Apache-2.0
/// A short version of the study in bench/assurance; docs/check-standard.md has the results of the long one.
#include <gtest/gtest.h>

#include "tests/support/check_study.hpp"

namespace gyrotherm::tests {
namespace {

#ifdef GYROTHERM_NIGHTLY
constexpr int kSeeds = 200;
#else
constexpr int kSeeds = 20;
#endif

StudyResult study(GoldenGyro golden, Injected injected) {
  StudyOptions options{.golden = golden, .injected = injected, .seeds = kSeeds};
  return simulate_histories(options);
}

TEST(AssuranceStudy, HasAtMostTheStatedFalseAlarms) {
  const auto result = study(GoldenGyro::single, Injected::none);
  EXPECT_EQ(result.judged_runs, kSeeds * 36);
  EXPECT_EQ(result.detected, 0);
  EXPECT_LE(binomial_interval(result.false_alarms, result.judged_runs).low, 0.01) << result.false_alarms;
}

TEST(AssuranceStudy, NamesThermometer) {
  const auto result = study(GoldenGyro::single, Injected::thermometer);
  EXPECT_EQ(result.detected, kSeeds);
  EXPECT_LE(quantile_95(result.runs_to_detection), 4);
  EXPECT_GE(result.right, 0.9 * result.detected) << result.wrong << " wrong";
}

TEST(AssuranceStudy, NamesTiltOfMountInTwoPositions) {
  const auto result = study(GoldenGyro::turned, Injected::mount);
  EXPECT_GE(result.detected, 0.95 * kSeeds);
  EXPECT_LE(median(result.runs_to_detection), 2);
  EXPECT_GE(result.right, 0.9 * result.detected) << result.wrong << " wrong";
}

TEST(AssuranceStudy, NamesDriftOfGyroInTwoPositions) {
  const auto result = study(GoldenGyro::turned, Injected::gyro);
  EXPECT_GE(result.detected, 0.5 * kSeeds) << "0.002 °/h is less than twice the turn-on";
  EXPECT_GE(result.right, 0.9 * result.detected) << result.wrong << " wrong";
}

TEST(AssuranceStudy, DoesNotTellDriftFromSmallTiltOfOneAxis) {
  const auto result = study(GoldenGyro::single, Injected::gyro);
  EXPECT_GE(result.detected, 0.5 * kSeeds);
  EXPECT_LE(result.wrong, 0.05 * kSeeds) << "names nothing rather than the wrong cause";
}

}  // namespace
}  // namespace gyrotherm::tests
