// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/chi_squared.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gyrotherm::data {
namespace {

TEST(ChiSquared, IsThatOfTheTables) {
  // Abramowitz and Stegun, table 26.8: the values that are exceeded with these probabilities.
  EXPECT_NEAR(chi_squared_exceeds(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(18.3070, 10), 0.05, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(31.4104, 20), 0.05, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(37.5662, 20), 0.01, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(8.26040, 20), 0.99, 1e-6);
  EXPECT_NEAR(chi_squared_exceeds(149.449, 100), 0.001, 1e-6);
}

TEST(ChiSquared, OfTwoDegreesIsTheExponential) {
  for (const double value : {0.0, 0.3, 2.0, 5.0, 40.0, 400.0}) {
    EXPECT_NEAR(chi_squared_exceeds(value, 2), std::exp(-value / 2), 1e-14);
  }
}

TEST(ChiSquared, HasItsLimitWhereItIsExceededAsOftenAsWasAsked) {
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

TEST(NoncentralChiSquared, OfOneDegreeIsTheSquareOfAShiftedNormal) {
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

/// Of three degrees, root r and mean m the density of r is (r/m)(φ(r − m) − φ(r + m)).
TEST(NoncentralChiSquared, OfThreeDegreesHasItsClosedForm) {
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

TEST(NoncentralChiSquared, WithoutAShiftIsTheCentralOne) {
  for (const double value : {0.0, 0.7, 5.0, 60.0}) {
    EXPECT_NEAR(noncentral_chi_squared_exceeds(value, 5, 0), chi_squared_exceeds(value, 5), 1e-15);
  }
}

}  // namespace
}  // namespace gyrotherm::data
