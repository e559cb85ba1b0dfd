// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "report/plot/thermal_image.hpp"

namespace gyrotherm::plot {
namespace {

SampledField sampled(std::size_t columns, std::size_t rows, auto value) {
  SampledField field{columns, rows, {}};
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      field.values.push_back(value(static_cast<double>(column), static_cast<double>(row)));
    }
  }
  return field;
}

double length(const Isotherm& line) {
  double sum = 0;
  for (std::size_t k = 1; k < line.size(); ++k) {
    sum += std::hypot(line[k].column - line[k - 1].column, line[k].row - line[k - 1].row);
  }
  return sum;
}

bool closed(const Isotherm& line) {
  return std::hypot(line.front().column - line.back().column, line.front().row - line.back().row) < 1e-12;
}

}  // namespace

TEST(Isotherms, FormOneStraightLineInPlane) {
  const auto field = sampled(20, 10, [](double x, double y) { return x + 0.5 * y; });
  const auto lines = isotherms(field, 7.25);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_FALSE(closed(lines[0]));
  for (const auto& point : lines[0]) EXPECT_NEAR(point.column + 0.5 * point.row, 7.25, 1e-12);
  EXPECT_NEAR(length(lines[0]), std::hypot(9, 4.5), 1e-12);
}

TEST(Isotherms, FormOneClosedCircleAroundHill) {
  const auto field = sampled(101, 101, [](double x, double y) { return -std::hypot(x - 50.3, y - 49.6); });
  const auto lines = isotherms(field, -30);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(closed(lines[0]));
  EXPECT_NEAR(length(lines[0]), 2 * std::numbers::pi * 30, 0.05);
}

TEST(Isotherms, EndAtBorderOfField) {
  auto field = sampled(40, 40, [](double x, double) { return x; });
  field.values[20 * 40 + 10] = std::numeric_limits<double>::quiet_NaN();
  const auto lines = isotherms(field, 10.5);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_NEAR(length(lines[0]) + length(lines[1]), 37, 1e-12);
}

TEST(Isotherms, DoNotExistOutsideRange) {
  const auto field = sampled(5, 5, [](double x, double y) { return x * y; });
  EXPECT_TRUE(isotherms(field, -1).empty());
  EXPECT_TRUE(isotherms(field, 17).empty());
}

TEST(Isotherms, AreClosedOrEndAtBorderInRandomFields) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto field = sampled(17, 13, [&](double, double) { return static_cast<double>(random() % 1000); });
    for (const auto& line : isotherms(field, 499.5)) {
      ASSERT_GE(line.size(), 2U);
      if (closed(line)) continue;
      for (const auto& end : {line.front(), line.back()}) {
        const bool on_edge = end.column == 0 || end.row == 0 || end.column == 16 || end.row == 12;
        EXPECT_TRUE(on_edge) << end.column << ' ' << end.row;
      }
    }
  }
}

}  // namespace gyrotherm::plot
