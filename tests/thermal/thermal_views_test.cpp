// SPDX-License-Identifier: Apache-2.0
#include "thermal/thermal_views.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr double kEdge_mm = 9.0;

TEST(ThermalViews, TopFaceShowsTheBlockWithoutItsCabinet) {
  const GyroModel model = shipped_gyro("calibrated");
  const GyroMesh mesh = make_mesh(model, kEdge_mm);
  const auto state = steady_state(model, mesh);
  ASSERT_TRUE(state) << text(state.error());
  const plot::ThermalImage image = top_face_of(model, mesh, *state, 128);
  // A block of 110 mm about 75 mm, ballasts of 6.66 mm on its sides, the cathode of 16 mm on its upper face, 2 mm
  // around.
  EXPECT_EQ(image.x_mm.low, 11);
  EXPECT_EQ(image.x_mm.high, 139);
  EXPECT_EQ(image.y_mm.low, 18);
  EXPECT_EQ(image.y_mm.high, 148);
  EXPECT_EQ(image.celsius.columns, 128U);
  EXPECT_EQ(image.celsius.rows, 130U);
  EXPECT_TRUE(can_be_drawn(image));
  EXPECT_TRUE(image.simulated);
  ASSERT_EQ(image.marks.size(), 8U);
  const plot::ThermalMark& a = image.marks.front();
  EXPECT_EQ(a.name, "A");
  EXPECT_EQ(a.x_mm, 75);
  EXPECT_EQ(a.y_mm, 125);
  EXPECT_NEAR(image.celsius.at(23, 64), a.celsius, 0.1) << "the sample below 125 mm of 148, right of 75 mm";
  EXPECT_TRUE(std::isnan(image.celsius.at(73, 64))) << "the hub in the hole is not coloured";
  EXPECT_LE(image.colours_c.low, image.celsius.at(23, 64));
  EXPECT_GE(image.colours_c.high, image.celsius.at(23, 64));
}

}  // namespace
}  // namespace gyrotherm::thermal
