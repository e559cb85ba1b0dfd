// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/distributions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace gyrotherm::data {
namespace {

TEST(ChiSquared, MatchesPublishedTables) {
  // Percentage points from Abramowitz and Stegun, table 26.8.
  EXPECT_NEAR(chi_squared_exceeds(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(18.3070, 10), 0.05, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(31.4104, 20), 0.05, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(37.5662, 20), 0.01, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(8.26040, 20), 0.99, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(149.449, 100), 0.001, 1e-6);
}

TEST(ChiSquared, IsExponentialForTwoDegreesOfFreedom) {
  for (const double value : {0.0, 0.3, 2.0, 5.0, 40.0, 400.0}) {
    EXPECT_NEAR(chi_squared_exceeds(value, 2), std::exp(-value / 2), 1e-14);
  }
}

TEST(ChiSquared, InvertsProbabilityAtLimit) {
  EXPECT_NEAR(chi_squared_limit(0.05, 1), 3.84146, 1e-5);
  EXPECT_NEAR(chi_squared_limit(0.001, 100), 149.449, 1e-3);
  for (const double probability : {0.999, 0.5, 1e-3, 1e-9, 1e-100}) {
    EXPECT_NEAR(chi_squared_limit(probability, 2), -2 * std::log(probability), 1e-9 - 1e-9 * std::log(probability));
    for (const double freedom : {1.0, 3.0, 14.5}) {
      const double found = chi_squared_exceeds(chi_squared_limit(probability, freedom), freedom);
      EXPECT_NEAR(found / probability, 1, 1e-10) << probability << ", " << freedom;
    }
  }
}

double normal_exceeds(double value) { return 0.5 * std::erfc(value / std::numbers::sqrt2); }

TEST(NoncentralChiSquared, IsSquareOfShiftedNormalForOneDegreeOfFreedom) {
  for (const double mean : {0.0, 0.1, 1.0, 3.0, 8.0, 30.0}) {
    for (const double root : {0.5, 2.0, 7.0, 29.0, 33.0}) {
      const double exact = normal_exceeds(root - mean) + normal_exceeds(root + mean);
      EXPECT_NEAR(noncentral_chi_squared_exceeds(root * root, 1, mean * mean), exact, 1e-12 + 1e-9 * exact)
          << mean << ", " << root;
      const double density =
          (std::exp(-0.5 * (root - mean) * (root - mean)) + std::exp(-0.5 * (root + mean) * (root + mean))) /
          (2 * root * std::sqrt(2 * std::numbers::pi));
      EXPECT_NEAR(noncentral_chi_squared_density(root * root, 1, mean * mean), density, 1e-12 + 1e-9 * density);
    }
  }
}

/// For three degrees of freedom and a mean of length m, the square root r of χ² has the density
/// (r/m)(φ(r − m) − φ(r + m)).
TEST(NoncentralChiSquared, MatchesClosedFormForThreeDegreesOfFreedom) {
  const auto normal = [](double x) { return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi); };
  for (const double mean : {0.2, 2.0, 11.0}) {
    for (const double root : {0.3, 3.0, 12.5}) {
      const double density = (normal(root - mean) - normal(root + mean)) / (2 * mean);
      EXPECT_NEAR(noncentral_chi_squared_density(root * root, 3, mean * mean), density, 1e-13 + 1e-9 * density);
      const double exceeds = normal_exceeds(root - mean) + normal_exceeds(root + mean) +
                             (normal(root - mean) - normal(root + mean)) / mean;
      EXPECT_NEAR(noncentral_chi_squared_exceeds(root * root, 3, mean * mean), exceeds, 1e-12);
    }
  }
}

TEST(NoncentralChiSquared, EqualsCentralDistributionWithoutShift) {
  for (const double value : {0.0, 0.7, 5.0, 60.0}) {
    EXPECT_NEAR(noncentral_chi_squared_exceeds(value, 5, 0), chi_squared_exceeds(value, 5), 1e-15);
  }
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(StudentsT, MatchesPublishedCoverageFactors) {
  struct Published {
    double degrees_of_freedom, factor_90, factor_95, factor_99;
  };
  // Table G.2 of the GUM (JCGM 100:2008).
  constexpr Published kTable[] = {{1, 6.31, 12.71, 63.66},         {2, 2.92, 4.30, 9.92},  {3, 2.35, 3.18, 5.84},
                                  {5, 2.02, 2.57, 4.03},           {10, 1.81, 2.23, 3.17}, {16, 1.75, 2.12, 2.92},
                                  {30, 1.70, 2.04, 2.75},          {50, 1.68, 2.01, 2.68}, {100, 1.660, 1.984, 2.626},
                                  {kInfinite, 1.645, 1.960, 2.576}};
  for (const Published& row : kTable) {
    const double rounding = row.degrees_of_freedom < 100 ? 0.0051 : 0.00051;
    EXPECT_NEAR(coverage_factor(0.90, row.degrees_of_freedom), row.factor_90, rounding) << row.degrees_of_freedom;
    EXPECT_NEAR(coverage_factor(0.95, row.degrees_of_freedom), row.factor_95, rounding) << row.degrees_of_freedom;
    EXPECT_NEAR(coverage_factor(0.99, row.degrees_of_freedom), row.factor_99, rounding) << row.degrees_of_freedom;
  }
}

TEST(StudentsT, MatchesClosedFormsForOneAndTwoDegreesOfFreedom) {
  for (const double t : {-30.0, -2.0, -0.1, 0.0, 0.3, 1.0, 4.0, 1e4}) {
    EXPECT_NEAR(students_t_probability(t, 1), 0.5 + std::atan(t) / std::numbers::pi, 1e-13) << t;
    EXPECT_NEAR(students_t_probability(t, 2), 0.5 + 0.5 * t / std::sqrt(2 + t * t), 1e-13) << t;
  }
}

TEST(StudentsT, ConvergesToNormalDistribution) {
  EXPECT_NEAR(coverage_factor(0.95, kInfinite), 1.959963984540054, 1e-12);
  EXPECT_NEAR(coverage_factor(0.95, 1e9), coverage_factor(0.95, kInfinite), 1e-6);
}

TEST(StudentsT, DecreasesWithDegreesOfFreedom) {
  double before = coverage_factor(0.95, 0.5);
  for (double degrees = 1; degrees < 1e7; degrees *= 1.7) {
    const double factor = coverage_factor(0.95, degrees);
    EXPECT_LT(factor, before) << degrees;
    EXPECT_NEAR(students_t_probability(factor, degrees), 0.975, 1e-12);
    before = factor;
  }
}

/// Exact intervals for ten trials; without a success the upper bound is 1 − 0.025^(1/10).
TEST(Binomial, IntervalMatchesTabulatedValues) {
  const auto expect = [](double successes, double trials, double low, double high) {
    const auto [lower, upper] = binomial_interval(successes, trials, 0.95);
    EXPECT_NEAR(lower, low, 5e-5) << successes << " of " << trials;
    EXPECT_NEAR(upper, high, 5e-5) << successes << " of " << trials;
  };
  expect(0, 10, 0, 0.3085);
  expect(10, 10, 0.6915, 1);
  expect(5, 10, 0.1871, 0.8129);
  expect(8, 10, 0.4439, 0.9748);
}

/// The bound and the test that judges the intervals of a model are of one distribution.
TEST(Binomial, UpperBoundIsWhereTestBecomesSignificant) {
  for (const double trials : {2.0, 7.3, 54.0, 216.0})
    for (const double share : {0.0, 0.5, 0.8613, 0.93}) {
      const double high = binomial_interval(share * trials, trials, 0.95).second;
      EXPECT_NEAR(binomial_at_most(share * trials, trials, high), 0.025, 1e-6) << share << " of " << trials;
    }
  EXPECT_EQ(binomial_interval(54, 54, 0.95).second, 1);
  EXPECT_EQ(binomial_interval(0, 54, 0.95).first, 0);
}

}  // namespace
}  // namespace gyrotherm::data
