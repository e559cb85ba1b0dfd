#include "report/format.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace gyrotherm {
namespace {

TEST(ReportNumber, HasFourDecimalsLikeThePaper) {
  EXPECT_EQ(bias_text(0.00214), "0.0021");
  EXPECT_EQ(bias_text(0.0258), "0.0258");
}

TEST(ReportNumber, HasATrueMinusAndNoNegativeZero) {
  EXPECT_EQ(bias_text(-0.0002), "−0.0002");
  EXPECT_EQ(bias_text(-0.00001), "0.0000");
}

TEST(ReportNumber, IsADashWhenThereIsNone) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(bias_text(none), "–");
  EXPECT_EQ(percent(none), "–");
  EXPECT_EQ(significant(none), "–");
}

TEST(ReportNumber, SaysFractionsInPerCent) { EXPECT_EQ(percent(0.76404), "76.4 %"); }

TEST(ReportNumber, KeepsThreeSignificantDigits) {
  EXPECT_EQ(significant(4.8412), "4.84");
  EXPECT_EQ(significant(84.2), "84.2");
  EXPECT_EQ(significant(0.0525), "0.0525");
  EXPECT_EQ(significant(3.1e-4), "3.10 × 10⁻⁴");
  EXPECT_EQ(significant(4096), "4096");
  EXPECT_EQ(significant(0), "0");
}

TEST(ReportText, IsEscapedForElementsAndAttributes) {
  EXPECT_EQ(escaped("a<b & \"c\" > 'd'"), "a&lt;b &amp; &quot;c&quot; &gt; &#39;d&#39;");
}

TEST(ReportText, LosesControlCharactersThatXmlForbids) {
  EXPECT_EQ(escaped(std::string("a\x01\x1f\tb\n°")), "a\tb\n°");
}

}  // namespace
}  // namespace gyrotherm
