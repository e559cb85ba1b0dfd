// SPDX-License-Identifier: Apache-2.0
#include "simulator/gyro_readout.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr DegreesPerHour kNoBias{};

TEST(GyroReadout, CountsWholePulsesOfAccumulatedAngle) {
  GyroReadout readout({.arcsec_per_pulse = 0.5, .earth_rate_deg_per_h = 10.2}, 0);
  for (int t = 0; t < 3; ++t) readout.step({0.1});
  EXPECT_EQ(readout.pulses(), 61);  // 30.9 arcsec
  readout.step({-100});
  EXPECT_EQ(readout.pulses(), -118);  // −58.9 arcsec, rounded down
}

TEST(GyroReadout, HasRequestedAngleRandomWalk) {
  GyroReadout readout({.arcsec_per_pulse = 1e-6, .angle_random_walk_deg_per_sqrt_h = 3e-4}, 7);
  std::vector<double> rates_deg_per_h;
  for (std::int64_t last = 0; rates_deg_per_h.size() < 100000; last = readout.pulses()) {
    readout.step(kNoBias);
    rates_deg_per_h.push_back(1e-6 * static_cast<double>(readout.pulses() - last));
  }
  EXPECT_NEAR(tests::standard_deviation(rates_deg_per_h), 60 * 3e-4, 4 * 0.018 / std::sqrt(2e5));
  EXPECT_NEAR(tests::standard_deviation(tests::clusters_of(rates_deg_per_h)), 6 * 3e-4, 4 * 0.0018 / std::sqrt(2e3));
}

TEST(GyroReadout, HasRequestedDeviationAndCorrelationTime) {
  GyroReadout readout({.drift_deg_per_h = 3e-4, .drift_time_s = 10}, 7);
  std::vector<double> drift;
  std::vector<double> now_and_10_s_ago;
  for (int t = 0; t < 400000; ++t) {
    readout.step(kNoBias);
    drift.push_back(readout.drift().value);
    if (t >= 10) now_and_10_s_ago.push_back(drift[drift.size() - 1] * drift[drift.size() - 11]);
  }
  EXPECT_NEAR(tests::standard_deviation(drift), 3e-4, 0.03 * 3e-4);
  EXPECT_NEAR(tests::mean_of(now_and_10_s_ago) / 9e-8, std::exp(-1), 0.03);
}

TEST(GyroReadout, GrowsWithSquareRootOfTime) {
  constexpr double kWalk = 1e-3;
  std::vector<double> after_a_quarter;
  std::vector<double> after_an_hour;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    GyroReadout readout({.rate_random_walk_deg_per_h_per_sqrt_h = kWalk}, seed);
    for (int t = 0; t < 900; ++t) readout.step(kNoBias);
    after_a_quarter.push_back(readout.drift().value);
    for (int t = 900; t < 3600; ++t) readout.step(kNoBias);
    after_an_hour.push_back(readout.drift().value);
  }
  const double tolerance = 4 / std::sqrt(800.0);
  EXPECT_NEAR(tests::standard_deviation(after_a_quarter) / kWalk, 0.5, 0.5 * tolerance);
  EXPECT_NEAR(tests::standard_deviation(after_an_hour) / kWalk, 1, tolerance);
}

TEST(GyroReadout, DrawsEachTurnOnIndependently) {
  std::vector<double> offsets;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const GyroReadout readout({.turn_on_deg_per_h = 0.01, .turn_on_repeatability_deg_per_h = 0.002}, seed);
    offsets.push_back(readout.drift().value);
  }
  EXPECT_NEAR(tests::mean_of(offsets), 0.01, 4 * 0.002 / std::sqrt(2000.0));
  EXPECT_NEAR(tests::standard_deviation(offsets), 0.002, 4 * 0.002 / std::sqrt(4000.0));
}

TEST(GyroReadout, HasRequestedBiasInstability) {
  std::vector<double> drift;
  GyroReadout readout({.instability_deg_per_h = 1e-3, .instability_from_s = 1, .instability_to_s = 100}, 3);
  for (int t = 0; t < 100000; ++t) {
    drift.push_back(readout.drift().value);
    readout.step(kNoBias);
  }
  double variance = 0;
  for (const auto& process : flicker_processes(1e-3, 1, 100)) variance += process.sigma * process.sigma;
  EXPECT_NEAR(tests::standard_deviation(drift) / std::sqrt(variance), 1, 0.1);
}

TEST(GyroReadout, HasOwnClock) {
  GyroReadout readout({.clock_skew_ppm = 5}, 0);
  for (int t = 0; t < 1000; ++t) readout.step(kNoBias);
  EXPECT_EQ(readout.device_time_us(), 1000005000);
}

}  // namespace
}  // namespace gyrotherm::simulator
