// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "simulator/gyro_readout.hpp"
#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

/// Returns the Allan variance of a first-order Markov process (IEEE Std 952, annex C.1.1.5).
double allan_variance(const MarkovProcess& process, double tau_s) {
  const double x = tau_s / process.correlation_time_s;
  return 2 * process.sigma * process.sigma / x * (1 - (3 - 4 * std::exp(-x) + std::exp(-2 * x)) / (2 * x));
}

TEST(Flicker, HasFlatAllanDeviationInMiddleDecades) {
  constexpr double kLevel = 5e-4;
  const auto processes = flicker_processes(kLevel, 1, 1e6);
  for (const double tau_s : {100.0, 300.0, 1000.0, 3000.0, 10000.0}) {
    double variance = 0;
    for (const auto& process : processes) variance += allan_variance(process, tau_s);
    EXPECT_NEAR(std::sqrt(variance) / (kLevel * std::sqrt(2 * std::numbers::ln2 / std::numbers::pi)), 1, 0.02) << tau_s;
  }
}

TEST(Flicker, IsZeroAtLevelZero) {
  EXPECT_TRUE(flicker_processes(0, 1, 1e6).empty());
  Flicker none({}, {1, RandomPurpose::bias_instability});
  none.step();
  EXPECT_EQ(none.value(), 0);
}

TEST(Flicker, HasAllanDeviationOfItsProcesses) {
  const auto processes = flicker_processes(1, 1, 1e4);
  Flicker flicker(processes, {7, RandomPurpose::bias_instability});
  std::vector<double> values;
  for (int t = 0; t < 200000; ++t) {
    values.push_back(flicker.value());
    flicker.step();
  }
  const auto means = tests::clusters_of(values);
  double squares = 0;
  for (std::size_t i = 1; i < means.size(); ++i) squares += std::pow(means[i] - means[i - 1], 2);
  const double found = std::sqrt(squares / 2 / static_cast<double>(means.size() - 1));
  double variance = 0;
  for (const auto& process : processes) variance += allan_variance(process, 100);
  EXPECT_NEAR(found / std::sqrt(variance), 1, 4 / std::sqrt(2.0 * 1999)) << "standard error for 2000 means";
}

TEST(Flicker, StartsFromItsStationaryDistribution) {
  const auto processes = flicker_processes(1, 1, 1e6);
  std::vector<double> first;
  for (std::uint64_t seed = 0; seed < 2000; ++seed)
    first.push_back(Flicker(processes, {seed, RandomPurpose::bias_instability}).value());
  double variance = 0;
  for (const auto& process : processes) variance += process.sigma * process.sigma;
  EXPECT_NEAR(tests::standard_deviation(first) / std::sqrt(variance), 1, 4 / std::sqrt(4000.0));
}

}  // namespace
}  // namespace gyrotherm::simulator
