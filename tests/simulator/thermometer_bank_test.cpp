// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermometer_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

std::array<double, kThermalLocations> everywhere(double celsius) {
  std::array<double, kThermalLocations> places{};
  places.fill(celsius);
  return places;
}

EachThermometer each(double value) { return everywhere(value); }

TEST(ThermometerBank, RoundsToResolution) {
  const ThermometerBank bank({.resolution_k = each(0.01)}, everywhere(21.23678), 0);
  EXPECT_DOUBLE_EQ(bank.readings_c()[3], 21.24);
}

TEST(ThermometerBank, AddsErrorOfEachThermometer) {
  ThermometerParameters parameters;
  parameters.offset_k = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const ThermometerBank bank(parameters, everywhere(20), 0);
  for (std::size_t i = 0; i < kThermalLocations; ++i)
    EXPECT_DOUBLE_EQ(bank.readings_c()[i], 20 + static_cast<double>(i));
}

TEST(ThermometerBank, FollowsWithTimeConstant) {
  ThermometerBank bank({.time_constant_s = each(30)}, everywhere(0), 0);
  for (int t = 0; t < 30; ++t) bank.step(everywhere(1));
  EXPECT_NEAR(bank.readings_c()[0], 1 - std::exp(-1), 1e-12);
}

TEST(ThermometerBank, FollowsWithTimeConstantOfEachThermometer) {
  ThermometerParameters parameters;
  for (std::size_t i = 0; i < kThermalLocations; ++i) parameters.time_constant_s[i] = 10.0 * static_cast<double>(i);
  ThermometerBank bank(parameters, everywhere(0), 0);
  for (int t = 0; t < 20; ++t) bank.step(everywhere(1));
  EXPECT_EQ(bank.readings_c()[0], 1) << "none";
  for (std::size_t i = 1; i < kThermalLocations; ++i)
    EXPECT_NEAR(bank.readings_c()[i], 1 - std::exp(-2 / static_cast<double>(i)), 1e-12);
}

TEST(ThermometerBank, HasGainErrorAbout20Degrees) {
  ThermometerParameters parameters;
  parameters.gain = {0, 1e-3, -1e-3, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(ThermometerBank(parameters, everywhere(20), 0).readings_c()[1], 20);
  const ThermometerBank hot(parameters, everywhere(60), 0);
  EXPECT_NEAR(hot.readings_c()[0], 60, 1e-12);
  EXPECT_NEAR(hot.readings_c()[1], 60.04, 1e-12);
  EXPECT_NEAR(hot.readings_c()[2], 59.96, 1e-12);
}

/// The drift is a random walk. Its variance is proportional to the days since the calibration, including those of the
/// run.
TEST(ThermometerBank, DriftsSinceCalibration) {
  const ThermometerParameters parameters{.drift_k_per_sqrt_day = each(0.01), .days_since_calibration = 4};
  std::vector<double> at_start_k;
  std::vector<double> in_an_hour_k;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    ThermometerBank bank(parameters, everywhere(20), seed);
    const auto start = bank.readings_c();
    const std::vector<double> before(start.begin(), start.end());
    for (int t = 0; t < 3600; ++t) bank.step(everywhere(20));
    for (std::size_t i = 0; i < kThermalLocations; ++i) {
      at_start_k.push_back(before[i] - 20);
      in_an_hour_k.push_back(bank.readings_c()[i] - before[i]);
    }
  }
  const double tolerance = 4 / std::sqrt(1800.0);
  EXPECT_NEAR(tests::standard_deviation(at_start_k) / 0.02, 1, tolerance);
  EXPECT_NEAR(tests::standard_deviation(in_an_hour_k) / (0.01 / std::sqrt(24.0)), 1, tolerance);
}

TEST(ThermometerBank, HasRequestedNoise) {
  ThermometerBank bank({.noise_k = each(0.01)}, everywhere(20), 1);
  std::vector<double> readings;
  for (int t = 0; t < 20000; ++t) {
    bank.step(everywhere(20));
    readings.push_back(bank.readings_c()[8]);
  }
  EXPECT_NEAR(tests::standard_deviation(readings), 0.01, 4 * 0.01 / std::sqrt(4e4));
}

}  // namespace
}  // namespace gyrotherm::simulator
