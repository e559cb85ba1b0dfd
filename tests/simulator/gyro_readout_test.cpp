#include "simulator/gyro_readout.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/simulator/statistics.hpp"

namespace gyrotherm {
namespace {

constexpr DegreesPerHour kNoBias{};

TEST(GyroReadout, CountsWholePulsesOfTheAccumulatedAngle) {
  GyroReadout readout({.arcsec_per_pulse = 0.5, .earth_rate_deg_per_h = 10.2}, 0);
  for (int t = 0; t < 3; ++t) readout.step({0.1});
  EXPECT_EQ(readout.pulses(), 61);  // 30.9 arcsec
  readout.step({-100});
  EXPECT_EQ(readout.pulses(), -118);  // −58.9 arcsec, rounded down
}

TEST(GyroReadout, HasTheAngleRandomWalkAsked) {
  GyroReadout readout({.arcsec_per_pulse = 1e-6, .angle_random_walk_deg_per_sqrt_h = 3e-4}, 7);
  std::vector<double> rates_deg_per_h;
  for (std::int64_t last = 0; rates_deg_per_h.size() < 100000; last = readout.pulses()) {
    readout.step(kNoBias);
    rates_deg_per_h.push_back(1e-6 * static_cast<double>(readout.pulses() - last));
  }
  EXPECT_NEAR(standard_deviation_of(rates_deg_per_h), 60 * 3e-4, 4 * 0.018 / std::sqrt(2e5));
  EXPECT_NEAR(standard_deviation_of(clusters_of(rates_deg_per_h)), 6 * 3e-4, 4 * 0.0018 / std::sqrt(2e3));
}

TEST(GyroReadout, DriftsWithTheDeviationAndCorrelationTimeAsked) {
  GyroReadout readout({.drift_deg_per_h = 3e-4, .drift_time_s = 10}, 7);
  std::vector<double> drift;
  std::vector<double> now_and_10_s_ago;
  for (int t = 0; t < 400000; ++t) {
    readout.step(kNoBias);
    drift.push_back(readout.drift().value);
    if (t >= 10) now_and_10_s_ago.push_back(drift[drift.size() - 1] * drift[drift.size() - 11]);
  }
  EXPECT_NEAR(standard_deviation_of(drift), 3e-4, 0.03 * 3e-4);
  EXPECT_NEAR(mean_of(now_and_10_s_ago) / 9e-8, std::exp(-1), 0.03);
}

TEST(GyroReadout, KeepsATimeOfItsOwn) {
  GyroReadout readout({.clock_skew_ppm = 5}, 0);
  for (int t = 0; t < 1000; ++t) readout.step(kNoBias);
  EXPECT_EQ(readout.device_time_us(), 1000005000);
}

}  // namespace
}  // namespace gyrotherm
