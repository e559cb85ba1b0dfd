// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "report/plot/svg.hpp"

namespace gyrotherm::plot {
namespace {

TEST(ReportNumber, HasFourDecimalsLikePaper) {
  EXPECT_EQ(format_bias(0.00214), "0.0021");
  EXPECT_EQ(format_bias(0.0258), "0.0258");
}

TEST(ReportNumber, HasTrueMinusAndNoNegativeZero) {
  EXPECT_EQ(format_bias(-0.0002), "−0.0002");
  EXPECT_EQ(format_bias(-0.00001), "0.0000");
}

TEST(ReportNumber, IsDashForNan) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(format_bias(none), "–");
  EXPECT_EQ(percent(none), "–");
  EXPECT_EQ(format_significant(none), "–");
}

TEST(ReportNumber, FormatsFractionsInPerCent) { EXPECT_EQ(percent(0.76404), "76.4 %"); }

TEST(ReportNumber, KeepsThreeSignificantDigits) {
  EXPECT_EQ(format_significant(4.8412), "4.84");
  EXPECT_EQ(format_significant(84.2), "84.2");
  EXPECT_EQ(format_significant(0.0525), "0.0525");
  EXPECT_EQ(format_significant(3.1e-4), "3.10 × 10⁻⁴");
  EXPECT_EQ(format_significant(4096), "4096");
  EXPECT_EQ(format_significant(0), "0");
}

TEST(ReportText, IsEscapedForElementsAndAttributes) {
  EXPECT_EQ(escaped("a<b & \"c\" > 'd'"), "a&lt;b &amp; &quot;c&quot; &gt; &#39;d&#39;");
}

TEST(ReportText, DropsControlCharactersForbiddenInXml) {
  EXPECT_EQ(escaped(std::string("a\x01\x1f\tb\n°")), "a\tb\n°");
}

TEST(Format, RoundsValueToDigitsOfError) {
  EXPECT_EQ(format_with_error(0.0021432, 0.000057), "0.002143 ± 0.000057");
  EXPECT_EQ(format_with_error(12.345, 0.31), "12.35 ± 0.31");
  EXPECT_EQ(format_with_error(1234.6, 21), "1235 ± 21");
  EXPECT_EQ(format_with_error(-0.5, 0.25), "−0.50 ± 0.25");
  EXPECT_EQ(format_with_error(3.0e-7, 4e-9), "(3.000 ± 0.040) × 10⁻⁷");
}

TEST(Format, GivesErrorTwoDigits) {
  EXPECT_EQ(format_error(0.0000571), "0.000057");
  EXPECT_EQ(format_error(21.4), "21");
  EXPECT_EQ(format_error(4.2e-9), "4.20 × 10⁻⁹");
  EXPECT_EQ(format_error(std::numeric_limits<double>::quiet_NaN()), "–");
}

TEST(Format, OmitsMissingError) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(format_with_error(0.00214, none), format_significant(0.00214));
  EXPECT_EQ(format_with_error(0.00214, 0), format_significant(0.00214));
  EXPECT_EQ(format_with_error(none, none), "–");
}

TEST(Format, LabelsLogarithmicAxisPlainlyNearOne) {
  EXPECT_EQ(digit_and_power(1, 0), "1");
  EXPECT_EQ(digit_and_power(5, -3), "0.005");
  EXPECT_EQ(digit_and_power(2, 3), "2000");
  EXPECT_EQ(digit_and_power(1, 5), "10⁵");
  EXPECT_EQ(digit_and_power(2, -4), "2 × 10⁻⁴");
}

}  // namespace
}  // namespace gyrotherm::plot
