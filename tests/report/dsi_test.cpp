// SPDX-License-Identifier: Apache-2.0
#include "report/dsi.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

namespace gyrotherm::report {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN(),
                 kEndless = std::numeric_limits<double>::infinity();

TEST(Dsi, ConvertsUnitsOfReport) {
  EXPECT_EQ(dsi_unit("1"), "\\one");
  EXPECT_EQ(dsi_unit("°C"), "\\degreecelsius");
  EXPECT_EQ(dsi_unit("K"), "\\kelvin");
  EXPECT_EQ(dsi_unit("s"), "\\second");
  EXPECT_EQ(dsi_unit("%"), "\\percent");
  EXPECT_EQ(dsi_unit("ppm"), "\\ppm");
  EXPECT_EQ(dsi_unit("hPa"), "\\hecto\\pascal");
  EXPECT_EQ(dsi_unit("°/h"), "\\degree\\per\\hour");
  EXPECT_EQ(dsi_unit("°/√h"), "\\degree\\per\\hour\\tothe{0.5}");
  EXPECT_EQ(dsi_unit("K/min"), "\\kelvin\\per\\minute");
  EXPECT_EQ(dsi_unit("1/h"), std::nullopt);
}

/// Readers disagree whether units after a second \per, or a second unit after \per, are in the denominator.
TEST(Dsi, HasAtMostOneUnitAfterPer) {
  EXPECT_EQ(dsi_unit("°/h/K"), "\\degree\\hour\\tothe{-1}\\kelvin\\tothe{-1}");
  EXPECT_EQ(dsi_unit("(°/h)/(K/min)"), "\\degree\\minute\\hour\\tothe{-1}\\kelvin\\tothe{-1}");
  EXPECT_EQ(dsi_unit("°/h/√h"), "\\degree\\hour\\tothe{-1}\\hour\\tothe{-0.5}");
  EXPECT_EQ(dsi_unit("°/h²"), "\\degree\\per\\hour\\tothe{2}");
}

TEST(Dsi, KeepsKilogram) { EXPECT_EQ(dsi_unit("kg"), "\\kilogram"); }

TEST(Dsi, ReturnsNothingForUnknownUnit) {
  for (const char* unit : {"", "furlong", "g", "g²", "m/g", "°/h/g", "°/", "/h", "(°/h", "°/h)", "° / h", "°C°", "√",
                           "<script>", "\\degree"})
    EXPECT_EQ(dsi_unit(unit), std::nullopt) << unit;
}

TEST(Dsi, RoundsValueToFourthDigitOfUncertainty) {
  const ReportedValue value{.value = 0.00214159265, .standard_uncertainty = 0.00003, .coverage_factor = 2};
  EXPECT_EQ(dsi_expanded(value), "0.00006000");
  EXPECT_EQ(dsi_value(value), "0.00214159");
  EXPECT_EQ(dsi_value({.value = 123456.7, .standard_uncertainty = 60'000, .coverage_factor = 2}), "123457");
  EXPECT_EQ(dsi_value({.value = 0.1 + 0.2}), "0.30000000000000004");
  EXPECT_EQ(dsi_coverage_factor({.coverage_factor = 2.0301079282503425}), "2.0301079283");
  EXPECT_EQ(dsi_coverage_factor({.coverage_factor = 2}), "2");
}

TEST(Dsi, LosesNothingComparedWithUncertainty) {
  std::mt19937_64 engine(20);
  std::uniform_real_distribution<double> exponent(-14, 9), sign(-1, 1);
  for (int i = 0; i < 20'000; ++i) {
    const double u = std::pow(10, exponent(engine));
    const ReportedValue value{
        .value = sign(engine) * std::pow(10, exponent(engine)), .standard_uncertainty = u, .coverage_factor = 2};
    EXPECT_NEAR(std::strtod(dsi_value(value).c_str(), nullptr), value.value, 0.001 * u + 1e-15 * std::abs(value.value));
    const double expanded = std::strtod(dsi_expanded(value).c_str(), nullptr);
    EXPECT_GE(expanded, 2 * u * (1 - 1e-11)) << u;
    EXPECT_LE(expanded, 2 * u * 1.0011) << u;
  }
}

TEST(Dsi, IgnoresInvalidUncertainty) {
  EXPECT_EQ(classify_certainty({}), Certainty::nothing);
  EXPECT_EQ(classify_certainty({.value = kEndless}), Certainty::nothing);
  EXPECT_EQ(classify_certainty({.value = 1}), Certainty::value);
  EXPECT_EQ(classify_certainty({.value = 1, .standard_uncertainty = 1}), Certainty::value);
  EXPECT_EQ(classify_certainty({.value = 1, .standard_uncertainty = 1, .coverage_factor = 0.5}), Certainty::value);
  EXPECT_EQ(classify_certainty({.value = 1, .standard_uncertainty = -1, .coverage_factor = 2}), Certainty::value);
  EXPECT_EQ(classify_certainty({.value = 1, .standard_uncertainty = kNotANumber, .coverage_factor = 2}),
            Certainty::value);
  EXPECT_EQ(classify_certainty(value_with_uncertainty(1, 0, kEndless)), Certainty::with_normal_u);
  EXPECT_EQ(classify_certainty(value_with_uncertainty(1, 1, 5)), Certainty::with_students_u);
}

}  // namespace
}  // namespace gyrotherm::report
