// SPDX-License-Identifier: Apache-2.0
#include "core/number_text.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace gyrotherm {
namespace {

TEST(NumberText, RoundsValueAndErrorTogether) {
  EXPECT_EQ(format_with_error(1.2, 0.15), "1.20 ± 0.15");
  EXPECT_EQ(format_with_error(0.019, 0.0002), "0.01900 ± 0.00020");
  EXPECT_EQ(format_with_error(-0.001756, 0.00148), "−0.0018 ± 0.0015");
  EXPECT_EQ(format_with_error(1100, 84), "1100 ± 84");
  EXPECT_EQ(format_with_error(56'789, 1234), "56800 ± 1200");
  EXPECT_EQ(format_with_error(-56'789, 99'600), "−60000 ± 100000");
  EXPECT_EQ(format_with_error(0, 0.5), "0.00 ± 0.50");
  EXPECT_EQ(format_with_error(0, 2e-9), "(0.0 ± 2.0) × 10⁻⁹");
}

/// An error that is rounded up to the next power of ten has no third digit.
TEST(NumberText, GivesRoundedUpErrorTwoDigits) {
  EXPECT_EQ(format_with_error(1, 0.0996), "1.00 ± 0.10");
  EXPECT_EQ(format_error(0.0996), "0.10");
  EXPECT_EQ(format_error(9.96), "10");
  EXPECT_EQ(format_error(996), "1000");
  EXPECT_EQ(decimals_for(0.0996), 2);
  EXPECT_EQ(decimals_for(4321), 0);
}

/// The exponent belongs to the rounded number: 9.996e-4 is 1.00e-3.
TEST(NumberText, TakesExponentAfterRounding) {
  EXPECT_EQ(format_significant(9.996e-4), "1.00 × 10⁻³");
  EXPECT_EQ(format_significant(0.0099996), "0.0100");
  EXPECT_EQ(format_significant(99.96), "100");
  EXPECT_EQ(format_significant(-9.999), "−10.0");
  EXPECT_EQ(format_significant(999'999), "1.00 × 10⁶");
  EXPECT_EQ(format_significant(160.4), "160");
}

TEST(NumberText, WritesDigitsWithoutPower) {
  EXPECT_EQ(format_digits(1.0726, 4), "1.073");
  EXPECT_EQ(format_digits(0.0819749, 4), "0.08197");
  EXPECT_EQ(format_digits(0.002, 4), "0.002000");
  EXPECT_EQ(format_digits(12'345.6, 4), "12346");
  EXPECT_EQ(format_digits(1e-7, 2), "1.0 × 10⁻⁷");
  EXPECT_EQ(format_digits(0, 4), "0");
  EXPECT_EQ(format_digits(std::numeric_limits<double>::quiet_NaN(), 4), "–");
}

TEST(NumberText, ReplacesHyphensOfNegativeNumbersOnly) {
  EXPECT_EQ(with_minus_signs("hold -20 °C (-0.5 K, -.25 K)"), "hold −20 °C (−0.5 K, −.25 K)");
  EXPECT_EQ(with_minus_signs("-1"), "−1");
  for (const char* same : {"2026-03-01", "1e-05", "in-sample", "G-1", "1-2", "--out", "- 5", "", "-"})
    EXPECT_EQ(with_minus_signs(same), same);
}

}  // namespace
}  // namespace gyrotherm
