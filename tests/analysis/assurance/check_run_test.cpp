// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/check_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.hpp"

namespace gyrotherm::assurance {
namespace {

constexpr double kNoise = 0.018;  // °/h in one second

/// Holds of 40 min at 20, 50 and -20 °C; the second one may be turned around. The bias of each plateau is 0.05 °/h +
/// 1e-4 °/h/K (T − 20 °C), and a tilt changes the Earth rate.
data::Dataset made_run(bool turned = false, double tilt_deg_per_h = 0) {
  constexpr Eigen::Index kHold = 2400;
  const std::vector<double> targets = turned ? std::vector<double>{20, 20, 50, -20} : std::vector<double>{20, 50, -20};
  data::Dataset run;
  run.path = "check.db";
  run.of.unit = "gyro";
  run.thermometers = {"A", "B", "C"};
  run.gradients = run.thermometers;
  run.earth_rate_deg_per_h = 10.6;
  const auto rows = static_cast<Eigen::Index>(targets.size()) * kHold;
  run.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  run.segment.resize(rows);
  run.temperature_c.resize(rows, 3);
  run.bias_deg_per_h.resize(rows);
  RandomStream random(4, RandomPurpose::drift);
  for (std::size_t s = 0; s < targets.size(); ++s)
    run.segments.push_back(
        {.name = "hold", .hold = true, .target = Celsius{targets[s]}, .unit = UnitState{.turned = turned && s == 1}});
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto segment = static_cast<std::size_t>(row / kHold);
    run.segment(row) = static_cast<int>(segment);
    run.temperature_c.row(row) << targets[segment], targets[segment] + 0.3, targets[segment] - 0.6;
    run.bias_deg_per_h(row) = 0.05 + 1e-4 * (targets[segment] - 20) + kNoise * random.normal() +
                              (run.segments[segment].unit.turned ? -tilt_deg_per_h : tilt_deg_per_h);
  }
  return run;
}

const CheckResult& find(const std::vector<CheckResult>& results, const std::string& what) {
  static const CheckResult kNone;
  const auto found = std::ranges::find_if(results, [&](const auto& one) { return label(one) == what; });
  EXPECT_NE(found, results.end()) << what;
  return found == results.end() ? kNone : *found;
}

TEST(CheckRun, MeasuresBiasCoefficientScatterAndDifferences) {
  const auto results = measure_check_run({made_run()});
  ASSERT_TRUE(results) << results.error().what;
  EXPECT_EQ(results->size(), 3 + 2 + 9u);
  const auto& bias = find(*results, "bias gyro 50 °C");
  EXPECT_NEAR(bias.value, 0.053, 4 * bias.u);
  EXPECT_NEAR(bias.u, kNoise / std::sqrt(1800), 0.4 * bias.u);
  const auto& coefficient = find(*results, "temperature_coefficient gyro");
  EXPECT_NEAR(coefficient.value, 1e-4, 4 * coefficient.u);
  const auto& scatter = find(*results, "scatter gyro");
  EXPECT_NEAR(scatter.value, kNoise / 10, 4 * scatter.u);
  EXPECT_NEAR(find(*results, "thermometer A 20 °C").value, 0.15, 1e-9) << "minus the mean of +0.3 and -0.6";
  EXPECT_NEAR(find(*results, "thermometer C -20 °C").value, -0.75, 1e-9);
}

TEST(CheckRun, SlowDriftOnPlateauIsNoScatter) {
  data::Dataset run = made_run();
  run.bias_deg_per_h.array() += 1e-5 * (run.time_s.array() - 3000);
  const auto drifting = measure_check_run({run}), quiet = measure_check_run({made_run()});
  ASSERT_TRUE(drifting && quiet);
  EXPECT_NEAR(find(*drifting, "scatter gyro").value, find(*quiet, "scatter gyro").value, 1e-9);
}

TEST(CheckRun, MeasuresEarthRateInTwoPositions) {
  const auto results = measure_check_run({made_run(true, 0.02)});
  ASSERT_TRUE(results) << results.error().what;
  const auto& rate = find(*results, "earth_rate gyro 20 °C, turned");
  EXPECT_NEAR(rate.value, 0.02, 4 * rate.u);
  EXPECT_LT(rate.u, 5e-4);
  EXPECT_NEAR(find(*results, "bias gyro 20 °C, turned").value, 0.03, 0.002);
}

TEST(CheckRun, RefusesUnknownEarthRateMissingReadingsAndShortHolds) {
  data::Dataset unknown = made_run();
  unknown.earth_rate_deg_per_h.reset();
  data::Dataset gap = made_run();
  gap.bias_deg_per_h.segment(2300, 20).setConstant(std::numeric_limits<double>::quiet_NaN());
  data::Dataset silent = made_run();
  silent.temperature_c.block(7000, 1, 50, 1).setConstant(std::numeric_limits<double>::quiet_NaN());
  data::Dataset ramps = made_run();
  for (auto& segment : ramps.segments) segment.hold = false;
  for (const data::Dataset& run : {unknown, gap, silent, ramps}) {
    const auto results = measure_check_run({run});
    ASSERT_FALSE(results);
    EXPECT_EQ(results.error().kind, FaultKind::usage);
    EXPECT_EQ(results.error().where, "check.db");
  }
}

TEST(CheckRun, ToleratesSingleMissingReadings) {
  data::Dataset run = made_run();
  for (Eigen::Index row = 50; row < run.bias_deg_per_h.size(); row += 97)
    run.bias_deg_per_h(row) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(measure_check_run({run}));
}

TEST(CheckRun, NamesRepeatedPlateaus) {
  data::Dataset run = made_run();
  run.segments[2].target = Celsius{20};
  const auto results = measure_check_run({run});
  ASSERT_TRUE(results) << results.error().what;
  find(*results, "bias gyro 20 °C");
  find(*results, "bias gyro 20 °C (2)");
}

TEST(CheckRun, MeasuresThermometersOfUnitOnce) {
  data::Dataset x = made_run(), y = made_run();
  x.of.axis = "x";
  y.of.axis = "y";
  const auto results = measure_check_run({x, y});
  ASSERT_TRUE(results) << results.error().what;
  EXPECT_EQ(std::ranges::count(*results, CheckKind::thermometer, &CheckResult::kind), 9);
  EXPECT_EQ(std::ranges::count(*results, CheckKind::bias, &CheckResult::kind), 6);
}

}  // namespace
}  // namespace gyrotherm::assurance
