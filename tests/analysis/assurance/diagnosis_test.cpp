// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/diagnosis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/check_study.hpp"

namespace gyrotherm::assurance {
namespace {

using tests::GoldenGyro;
using tests::Injected;

/// A history of 24 runs without a change; the tests change its last runs.
History quiet_history(GoldenGyro golden) {
  return tests::make_history({.golden = golden, .injected = Injected::none, .runs = 24}, 5, 24);
}

template <class Change>
void change_last_runs(History& history, std::size_t runs, Change change) {
  for (std::size_t r = history.checks.size() - runs; r < history.checks.size(); ++r)
    for (CheckResult& result : history.checks[r].results) change(result);
}

Diagnosis diagnose_all(const History& history) {
  const auto diagnosis = diagnose(history, assess(history));
  EXPECT_TRUE(diagnosis);
  return diagnosis.value_or(Diagnosis{});
}

TEST(Diagnosis, ReportsSizeAndBeginOfThermometerChange) {
  History history = quiet_history(GoldenGyro::single);
  change_last_runs(history, 3, [](CheckResult& result) {
    if (result.kind == CheckKind::thermometer) result.value += result.thermometer == "gyro.D" ? 0.08 : -0.01;
  });
  const auto diagnosis = diagnose_all(history);
  ASSERT_EQ(diagnosis.named, ChangeCause::thermometer);
  EXPECT_EQ(diagnosis.hypotheses.front().part, "gyro.D");
  EXPECT_NEAR(diagnosis.hypotheses.front().amount, 0.08, 0.02);
  EXPECT_EQ(diagnosis.since, 21u);
  EXPECT_EQ(diagnosis.after, 3u);
  EXPECT_FALSE(diagnosis.tilt_equals_drift) << "neither mount nor gyro is probable";
}

TEST(Diagnosis, NamesLastThermometerToo) {
  History history = quiet_history(GoldenGyro::single);
  change_last_runs(history, 2, [](CheckResult& result) {
    if (result.kind == CheckKind::thermometer) result.value += result.thermometer == "gyro.shell" ? -0.08 : 0.01;
  });
  const auto diagnosis = diagnose_all(history);
  ASSERT_EQ(diagnosis.named, ChangeCause::thermometer);
  EXPECT_EQ(diagnosis.hypotheses.front().part, "gyro.shell");
}

TEST(Diagnosis, MeasuresTiltOfVerticalAxis) {
  // A tilt of 0.2° towards north changes the Earth rate on a vertical axis by 15.041 cos 45° sin 0.2° = 0.0371 °/h.
  History history = quiet_history(GoldenGyro::single);
  change_last_runs(history, 2, [](CheckResult& result) {
    if (result.kind == CheckKind::bias) result.value += 0.0371;
  });
  const auto diagnosis = diagnose_all(history);
  ASSERT_EQ(diagnosis.named, ChangeCause::mount);
  EXPECT_NEAR(diagnosis.hypotheses.front().amount, 0.2, 0.02);
  EXPECT_TRUE(diagnosis.tilt_equals_drift) << "the size alone decides";
}

TEST(Diagnosis, NamesNoCauseForSmallConstantChangeOfOneAxis) {
  History history = quiet_history(GoldenGyro::single);
  change_last_runs(history, 8, [](CheckResult& result) {
    if (result.kind == CheckKind::bias) result.value += 0.004;
  });
  const auto diagnosis = diagnose_all(history);
  EXPECT_FALSE(diagnosis.named);
  EXPECT_TRUE(diagnosis.tilt_equals_drift);
  EXPECT_GT(diagnosis.probabilities[static_cast<int>(ChangeCause::mount)], 0.05);
  EXPECT_GT(diagnosis.probabilities[static_cast<int>(ChangeCause::gyro)], 0.05);
}

TEST(Diagnosis, TellsDriftFromTiltInTwoPositions) {
  History drifting = quiet_history(GoldenGyro::turned), tilted = drifting;
  change_last_runs(drifting, 6, [](CheckResult& result) {
    if (result.kind == CheckKind::bias) result.value += 0.006;
  });
  change_last_runs(tilted, 6, [](CheckResult& result) {
    if (result.kind == CheckKind::bias) result.value += result.turned ? -0.006 : 0.006;
  });
  EXPECT_EQ(diagnose_all(drifting).named, ChangeCause::gyro);
  EXPECT_EQ(diagnose_all(tilted).named, ChangeCause::mount);
  EXPECT_FALSE(diagnose_all(tilted).tilt_equals_drift);
}

TEST(Diagnosis, NamesGyroForChangeWithTemperature) {
  History history = quiet_history(GoldenGyro::single);
  change_last_runs(history, 3, [](CheckResult& result) {
    if (result.kind == CheckKind::bias) result.value += 2e-4 * (result.at_c - 20);
  });
  const auto diagnosis = diagnose_all(history);
  ASSERT_EQ(diagnosis.named, ChangeCause::gyro);
  EXPECT_EQ(diagnosis.hypotheses.front().part, "gyro, with temperature");
}

TEST(Diagnosis, NamesGyroForScatter) {
  History history = quiet_history(GoldenGyro::single);
  change_last_runs(history, 3, [](CheckResult& result) {
    if (result.kind == CheckKind::scatter) result.value *= 2;
  });
  const auto diagnosis = diagnose_all(history);
  ASSERT_EQ(diagnosis.named, ChangeCause::gyro);
  EXPECT_EQ(diagnosis.hypotheses.front().part, "gyro, scatter");
}

TEST(Diagnosis, NamesNoSingleCauseForTwoCauses) {
  History history = quiet_history(GoldenGyro::turned);
  change_last_runs(history, 4, [](CheckResult& result) {
    if (result.kind == CheckKind::bias) result.value += result.turned ? -0.02 : 0.02;
    if (result.kind == CheckKind::thermometer) result.value += result.thermometer == "gyro.B" ? 0.1 : -0.0125;
  });
  const auto diagnosis = diagnose_all(history);
  EXPECT_FALSE(diagnosis.named);
  EXPECT_LT(diagnosis.hypotheses.front().fits, kFits);
}

TEST(Diagnosis, NamesMountWhileThermometersDriftAsCertified) {
  // Half a year lies between the runs, in which the thermometers drift by 0.03 K; 0.05 K in a year are certified.
  History history = quiet_history(GoldenGyro::turned);
  for (std::size_t r = 20; r < history.checks.size(); ++r) {
    CheckEntry& check = history.checks[r];
    check.started_utc.replace(5, 2, "09");
    for (CheckResult& result : check.results) {
      if (result.kind == CheckKind::bias) result.value += result.turned ? -0.02 : 0.02;
      if (result.thermometer == "gyro.A" || result.thermometer == "gyro.B") result.value += 0.03;
      if (result.thermometer == "gyro.E" || result.thermometer == "gyro.F") result.value -= 0.03;
    }
  }
  EXPECT_EQ(diagnose_all(history).named, ChangeCause::mount);
  for (CheckEntry& check : history.checks)
    for (CheckedThermometer& thermometer : check.thermometers) thermometer.drift_k_per_year = 0;
  EXPECT_FALSE(diagnose_all(history).named) << "the drift is not certified";
}

TEST(Diagnosis, IsMissingForTooFewRuns) {
  History history = quiet_history(GoldenGyro::single);
  history.checks.resize(4);
  EXPECT_FALSE(diagnose(history, assess(history)));
}

TEST(Diagnosis, PosteriorsAreProbabilities) {
  const auto diagnosis = diagnose_all(quiet_history(GoldenGyro::triad));
  double sum = 0;
  for (const auto& one : diagnosis.hypotheses) {
    EXPECT_TRUE(std::isfinite(one.posterior));
    sum += one.posterior;
  }
  EXPECT_NEAR(sum, 1, 1e-9);
  EXPECT_TRUE(std::ranges::is_sorted(diagnosis.hypotheses, std::ranges::greater{}, &Hypothesis::posterior));
  EXPECT_EQ(diagnosis.hypotheses.size(), 27 + 1 + 9 + 1u);
}

}  // namespace
}  // namespace gyrotherm::assurance
