// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/students_t.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace gyrotherm::data {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(StudentsT, HasThePublishedCoverageFactors) {
  struct Published {
    double degrees_of_freedom, of_90, of_95, of_99;
  };
  // GUM (JCGM 100:2008), table G.2.
  constexpr Published kTable[] = {{1, 6.31, 12.71, 63.66},         {2, 2.92, 4.30, 9.92},  {3, 2.35, 3.18, 5.84},
                                  {5, 2.02, 2.57, 4.03},           {10, 1.81, 2.23, 3.17}, {16, 1.75, 2.12, 2.92},
                                  {30, 1.70, 2.04, 2.75},          {50, 1.68, 2.01, 2.68}, {100, 1.660, 1.984, 2.626},
                                  {kInfinite, 1.645, 1.960, 2.576}};
  for (const Published& row : kTable) {
    const double rounding = row.degrees_of_freedom < 100 ? 0.0051 : 0.00051;
    EXPECT_NEAR(coverage_factor(0.90, row.degrees_of_freedom), row.of_90, rounding) << row.degrees_of_freedom;
    EXPECT_NEAR(coverage_factor(0.95, row.degrees_of_freedom), row.of_95, rounding) << row.degrees_of_freedom;
    EXPECT_NEAR(coverage_factor(0.99, row.degrees_of_freedom), row.of_99, rounding) << row.degrees_of_freedom;
  }
}

TEST(StudentsT, IsWhatItsClosedFormsAreForOneAndTwoDegreesOfFreedom) {
  for (const double t : {-30.0, -2.0, -0.1, 0.0, 0.3, 1.0, 4.0, 1e4}) {
    EXPECT_NEAR(students_t_probability(t, 1), 0.5 + std::atan(t) / std::numbers::pi, 1e-13) << t;
    EXPECT_NEAR(students_t_probability(t, 2), 0.5 + 0.5 * t / std::sqrt(2 + t * t), 1e-13) << t;
  }
}

TEST(StudentsT, GoesOverIntoTheNormalDistribution) {
  EXPECT_NEAR(coverage_factor(0.95, kInfinite), 1.959963984540054, 1e-12);
  EXPECT_NEAR(coverage_factor(0.95, 1e9), coverage_factor(0.95, kInfinite), 1e-6);
}

TEST(StudentsT, FallsAsTheDegreesOfFreedomGrow) {
  double before = coverage_factor(0.95, 0.5);
  for (double degrees = 1; degrees < 1e7; degrees *= 1.7) {
    const double factor = coverage_factor(0.95, degrees);
    EXPECT_LT(factor, before) << degrees;
    EXPECT_NEAR(students_t_probability(factor, degrees), 0.975, 1e-12);
    before = factor;
  }
}

}  // namespace
}  // namespace gyrotherm::data
