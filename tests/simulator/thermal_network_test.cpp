// SPDX-License-Identifier: Apache-2.0
/// Compares with values of the reference simulation. There, the air equals the set point, each cycle starts at rest at
/// 20 °C, and the value of a second is that before its step.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "simulator/lumped_gyro.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr double kThirdDecimal = 0.5e-3 + 1e-9;
constexpr double kSecondDecimal = 0.5e-2 + 1e-9;

NetworkEquations reference() { return make_equations(lumped_of_rig("virtual-reference").network); }

/// Returns one series per location.
std::vector<std::vector<double>> driven_by(const std::vector<double>& air_c) {
  ThermalNetwork network(lumped_of_rig("virtual-reference").network);
  std::vector<std::vector<double>> series(kThermalLocations);
  for (const double air : air_c) {
    for (std::size_t i = 0; i < kThermalLocations; ++i) series[i].push_back(network.temperatures_c()[i]);
    network.step({air});
  }
  return series;
}

TEST(ThermalNetwork, RestsLikeReferenceAt20) {
  const auto rest_c = rest_temperatures(reference(), {20});
  const std::vector<double> expected{23.297, 23.146, 23.293, 21.873, 22.275, 21.488,
                                     21.546, 22.208, 21.202, 20.388, 20.960};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(rest_c[static_cast<Eigen::Index>(i)], expected[i], kThirdDecimal) << i;
  }
}

TEST(ThermalNetwork, RestsLikeReferenceAtMinus40) {
  EXPECT_NEAR(rest_temperatures(reference(), {-40})[0], -36.70, kSecondDecimal);
}

TEST(ThermalNetwork, StaysAtRest) {
  const auto series = driven_by(std::vector<double>(7200, 20.0));
  for (const auto& place : series) EXPECT_NEAR(place.front(), place.back(), 1e-9);
}

TEST(ThermalNetwork, HasTimeConstantsOfReference) {
  Eigen::VectorXd constants_min = -reference().rates.eigenvalues().real().cwiseInverse() / 60;
  std::sort(constants_min.begin(), constants_min.end(), std::greater<>());
  const std::vector<double> expected{45.84, 19.04, 18.29, 16.64, 12.09, 11.30, 9.23, 6.95, 6.71, 5.59, 1.99};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(constants_min[static_cast<Eigen::Index>(i)], expected[i], kSecondDecimal) << i;
  }
}

struct Span {
  double rate_c_per_min;
  double lowest_c;
  double highest_c;
};

TEST(ThermalNetwork, SpansTemperaturesOfReferenceInEachCycle) {
  for (const auto& expected :
       {Span{1, -33.916, 59.970}, Span{2, -32.972, 58.322}, Span{3, -32.543, 57.490}, Span{5, -32.137, 56.668}}) {
    const auto series = driven_by(rate_cycle_c(expected.rate_c_per_min));
    const auto [lowest, highest] = std::ranges::minmax_element(series[0]);
    EXPECT_NEAR(*lowest, expected.lowest_c, kThirdDecimal) << expected.rate_c_per_min;
    EXPECT_NEAR(*highest, expected.highest_c, kThirdDecimal) << expected.rate_c_per_min;
  }
}

TEST(ThermalNetwork, ReachesGradientsOfReference) {
  std::vector<std::vector<double>> clusters(kBlockLocations);
  for (const double rate : {1.0, 2.0, 3.0, 5.0}) {
    const auto series = driven_by(rate_cycle_c(rate));
    for (std::size_t i = 0; i < kBlockLocations; ++i)
      std::ranges::copy(tests::clusters_of(series[i]), std::back_inserter(clusters[i]));
  }
  ASSERT_EQ(clusters[0].size(), 2216U);
  const std::vector<double> lowest_k{-0.398, -2.599, -2.127, -4.301, 0.268, -0.309, -0.022};
  const std::vector<double> highest_k{0.687, 2.684, 4.882, 6.492, 3.390, 3.863, 2.232};
  for (std::size_t x = 1; x < kBlockLocations; ++x) {
    std::vector<double> gradient_k;
    std::ranges::transform(clusters[0], clusters[x], std::back_inserter(gradient_k), std::minus<>());
    EXPECT_NEAR(std::ranges::min(gradient_k), lowest_k[x - 1], kThirdDecimal) << kLocationNames[x];
    EXPECT_NEAR(std::ranges::max(gradient_k), highest_k[x - 1], kThirdDecimal) << kLocationNames[x];
  }
}

TEST(ThermalNetwork, EndsFirstColdHoldLikeReference) {
  const auto end_of_hold_c = [](double rate_c_per_min) {
    const auto cycle = rate_cycle_c(rate_c_per_min);
    const auto end = 7200 + static_cast<std::size_t>(3600 / rate_c_per_min) + 7200;
    return driven_by({cycle.begin(), cycle.begin() + static_cast<std::ptrdiff_t>(end)})[0].back();
  };
  EXPECT_NEAR(end_of_hold_c(1), -33.69, kSecondDecimal);
  EXPECT_NEAR(end_of_hold_c(5), -31.95, kSecondDecimal);
}

}  // namespace
}  // namespace gyrotherm::simulator
