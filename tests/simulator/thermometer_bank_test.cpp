#include "simulator/thermometer_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/simulator/statistics.hpp"

namespace gyrotherm {
namespace {

std::array<double, kThermalPlaces> everywhere(double celsius) {
  std::array<double, kThermalPlaces> places{};
  places.fill(celsius);
  return places;
}

TEST(ThermometerBank, RoundsToItsResolution) {
  const ThermometerBank bank({.resolution_k = 0.01}, everywhere(21.23678), 0);
  EXPECT_DOUBLE_EQ(bank.readings_c()[3], 21.24);
}

TEST(ThermometerBank, AddsEachThermometersOwnError) {
  ThermometerParameters parameters;
  parameters.offset_k = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const ThermometerBank bank(parameters, everywhere(20), 0);
  for (std::size_t i = 0; i < kThermalPlaces; ++i) EXPECT_DOUBLE_EQ(bank.readings_c()[i], 20 + static_cast<double>(i));
}

TEST(ThermometerBank, FollowsWithItsTimeConstant) {
  ThermometerBank bank({.time_constant_s = 30}, everywhere(0), 0);
  for (int t = 0; t < 30; ++t) bank.step(everywhere(1));
  EXPECT_NEAR(bank.readings_c()[0], 1 - std::exp(-1), 1e-12);
}

TEST(ThermometerBank, HasTheNoiseAsked) {
  ThermometerBank bank({.noise_k = 0.01}, everywhere(20), 1);
  std::vector<double> readings;
  for (int t = 0; t < 20000; ++t) {
    bank.step(everywhere(20));
    readings.push_back(bank.readings_c()[8]);
  }
  EXPECT_NEAR(standard_deviation_of(readings), 0.01, 4 * 0.01 / std::sqrt(4e4));
}

}  // namespace
}  // namespace gyrotherm
