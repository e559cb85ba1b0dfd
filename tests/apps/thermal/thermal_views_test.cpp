// SPDX-License-Identifier: Apache-2.0
#include "apps/thermal/thermal_views.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

constexpr double kEdge_mm = 9.0;

TEST(ThermalViews, TopFaceShowsTheBlockWithoutItsCabinet) {
  const auto model = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/calibrated.toml")
                         .and_then([](const std::string& toml) { return thermal::parse_gyro(toml, "calibrated"); })
                         .value();
  const thermal::GyroMesh mesh = make_mesh(model, kEdge_mm);
  const auto state = steady_state(model, mesh);
  ASSERT_TRUE(state) << text(state.error());
  const plot::ThermalImage image = make_top_face(model, mesh, *state, 114);
  // A block of 110 mm about 75 mm, and 2 mm around it; mirrors, cathode and ballasts are lower than its face.
  for (const plot::Range& range : {image.x_mm, image.y_mm}) {
    EXPECT_EQ(range.low, 18);
    EXPECT_EQ(range.high, 132);
  }
  EXPECT_EQ(image.celsius.columns, 114U);
  EXPECT_EQ(image.celsius.rows, 114U);
  EXPECT_TRUE(can_be_drawn(image));
  EXPECT_TRUE(image.simulated);
  ASSERT_EQ(image.marks.size(), 8U);
  const plot::ThermalMark& a = image.marks.front();
  EXPECT_EQ(a.name, "A");
  EXPECT_EQ(a.x_mm, 75);
  EXPECT_EQ(a.y_mm, 125);
  EXPECT_NEAR(image.celsius.at(6, 56), a.celsius, 0.1) << "the sample at 74.5, 125.5 mm";
  EXPECT_TRUE(std::isnan(image.celsius.at(57, 56))) << "the hub in the hole is not coloured";
  EXPECT_LE(image.colours_c.low, image.celsius.at(6, 56));
  EXPECT_GE(image.colours_c.high, image.celsius.at(6, 56));
}

}  // namespace
}  // namespace gyrotherm::app
