// SPDX-License-Identifier: Apache-2.0
#include "report/plot/thermal_image.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/json.hpp"
#include "report/plot/png.hpp"
#include "tests/support/markup.hpp"

namespace gyrotherm::plot {
namespace {

/// Returns an image that rises from 20 °C on the left to 30 °C on the right, with a hole in the middle and one
/// thermometer.
ThermalImage slope() {
  ThermalImage image{.title = "A slope",
                     .x_title = "x, mm",
                     .y_title = "y, mm",
                     .x_mm = {0, 100},
                     .y_mm = {0, 50},
                     .celsius = {200, 100, {}},
                     .parts = {},
                     .colours_c = {20, 30},
                     .marks = {{"A", 25, 40, 22.5}}};
  for (int row = 0; row < 100; ++row) {
    for (int column = 0; column < 200; ++column) {
      const bool hole = std::hypot(column - 100, row - 50) < 20;
      image.celsius.values.push_back(hole ? std::numeric_limits<double>::quiet_NaN() : 20 + 10 * column / 199.0);
      image.parts.push_back(hole ? 0 : 1);
    }
  }
  return image;
}

bool white(const Rgb& point) { return point.red == 255 && point.green == 255 && point.blue == 255; }

}  // namespace

TEST(ThermalImage, HasIsothermAtEachStep) {
  const auto levels = isotherm_levels(slope());
  ASSERT_EQ(levels.size(), 21U);
  EXPECT_DOUBLE_EQ(levels.front(), 20);
  EXPECT_DOUBLE_EQ(levels.back(), 30);
}

TEST(ThermalImage, IsBlueWhereColdRedWhereHotAndWhiteOutsideField) {
  Picture picture = colour_image(slope());
  const Rgb cold = picture.at(5, 0), hot = picture.at(5, 199);
  EXPECT_GT(cold.blue, cold.red);
  EXPECT_GT(hot.red, hot.blue);
  EXPECT_TRUE(white(picture.at(50, 100)));
}

TEST(ThermalImage, ShowsSimulatedAndNamesOfThermometers) {
  ThermalImage image = slope();
  EXPECT_EQ(to_svg(image).find("SIMULATED"), std::string::npos);
  image.simulated = true;
  const std::string svg = to_svg(image);
  EXPECT_NE(svg.find(">SIMULATED<"), std::string::npos);
  EXPECT_NE(svg.find(">A<"), std::string::npos);
  EXPECT_NE(svg.find(">22.50<"), std::string::npos);
  EXPECT_EQ(tests::markup_error(svg), "");
}

TEST(ThermalImage, ReadsBackFromJson) {
  ThermalImage image = slope();
  image.simulated = true;
  ThermalImage again;
  const auto place = JsonNode::parse(make_json(image).dump(), "image.json");
  ASSERT_TRUE(place);
  read_json(*place, again);
  ASSERT_TRUE(place->verdict()) << text(place->verdict().error());
  EXPECT_EQ(to_svg(again), to_svg(image));
}

TEST(ThermalImage, CannotBeDrawnWithMissingSamplesOrEmptyRanges) {
  EXPECT_TRUE(can_be_drawn(slope()));
  ThermalImage lacking = slope(), flat = slope(), wide = slope();
  lacking.celsius.values.pop_back();
  EXPECT_FALSE(can_be_drawn(lacking));
  flat.y_mm = {5, 5};
  EXPECT_FALSE(can_be_drawn(flat));
  wide.celsius.values.front() = 1e9;
  EXPECT_FALSE(can_be_drawn(wide));
}

TEST(Png, BeginsWithSignatureAndGivesEqualBytes) {
  const std::string once = to_png(colour_image(slope())), again = to_png(colour_image(slope()));
  EXPECT_EQ(once.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(once, again);
}

TEST(Base64, MatchesVectorsOfStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace gyrotherm::plot
