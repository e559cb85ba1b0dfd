// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "simulator/thermal/gyro_model.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

/// Returns the calibrated gyro with one part of its text replaced.
Result<GyroModel> with(const std::string& piece, const std::string& replacement) {
  auto text = gyro_text("calibrated");
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return parse_gyro(text.replace(at, piece.size(), replacement), "gyro.toml");
}

void expect_error(const Result<GyroModel>& model, const std::string& what) {
  ASSERT_FALSE(model) << what;
  EXPECT_EQ(model.error().kind, FaultKind::bad_file);
  EXPECT_TRUE(model.error().where.starts_with("gyro.toml:")) << model.error().where;
  EXPECT_NE(model.error().what.find(what), std::string::npos) << model.error().what;
}

TEST(GyroFile, ReadsEveryShippedFile) {
  for (const char* name : {"calibrated", "fast-film"}) {
    const auto model = parse_gyro(gyro_text(name), name);
    ASSERT_TRUE(model) << text(model.error());
    EXPECT_EQ(model->name, name);
    EXPECT_EQ(model->mode, GyroMode::full);
  }
}

TEST(GyroFile, HasPowersOfPaper) {
  const auto model = shipped_gyro("calibrated");
  EXPECT_DOUBLE_EQ(model.powers_w[0] + model.powers_w[1], 0.588);
  EXPECT_DOUBLE_EQ(model.powers_w[2], 0.784);
  EXPECT_NEAR(model.powers_w[3], 0.0720, 1e-4);
  EXPECT_EQ(model.powers_w[3], model.powers_w[4]);
}

TEST(GyroFile, AcceptsEachReadingOfBallast) {
  const std::string nominal = "reading = \"rate x volume\"";
  EXPECT_DOUBLE_EQ(with(nominal, "reading = \"printed, each\"")->powers_w[3], 0.027);
  EXPECT_DOUBLE_EQ(with(nominal, "reading = \"printed, both together\"")->powers_w[4], 0.0135);
  EXPECT_DOUBLE_EQ(with(nominal, "reading = \"none\"")->powers_w[3], 0);
  expect_error(with(nominal, "reading = \"printed\""), "printed");
}

TEST(GyroFile, PlacesPreamplifierAtThreeMounts) {
  for (const char* place : {"wall", "lid", "base"}) {
    const auto model = with("place = \"wall\"", std::string("place = \"") + place + "\"");
    ASSERT_TRUE(model) << text(model.error());
    EXPECT_EQ(kPreamplifierMountNames[static_cast<std::size_t>(model->geometry.preamplifier_mount)], place);
  }
}

TEST(GyroFile, DistributesGainPowerToUnequalArms) {
  const auto model = with("left_share = 0.5", "left_share = 0.6");
  EXPECT_NEAR(model->powers_w[0] / model->powers_w[1], 1.5, 1e-12);
}

TEST(GyroFile, ComputesGapWidthsFromGeometry) {
  const auto model = shipped_gyro("calibrated");
  EXPECT_NEAR(model.air.lid.width_m, 0.0245, 1e-12);
  EXPECT_NEAR(model.air.side.width_m, 0.017, 1e-12);
}

TEST(GyroFile, ReportsSizesThatAreNotPositive) {
  expect_error(with("thickness_mm = 25 ", "thickness_mm = 0 "), "0 is not above 0");
  expect_error(with("wall_mm = 3", "wall_mm = -3"), "-3 is not above 0");
  expect_error(with("size_mm = [20, 16, 20]", "size_mm = [20, -16, 20]"), "-16 is not above 0");
  expect_error(with("size_mm = [20, 16, 20]", "size_mm = [20, 16]"), "expected 3");
  expect_error(with("density_kg_per_m3 = 2530", "density_kg_per_m3 = nan"), "nan, expected a number");
}

TEST(GyroFile, ReportsOverlappingParts) {
  expect_error(with("size_mm = [70, 50, 10]", "size_mm = [70, 20, 25]"), "preamplifier overlaps block");
}

TEST(GyroFile, ReportsPartsOutsideCabinet) {
  expect_error(with("size_mm = [150, 150, 80]", "size_mm = [150, 145, 80]"), "cathode reaches outside");
  expect_error(with("top_w_mm = 15", "top_w_mm = 38"), "hub reaches outside");
  expect_error(with("size_mm = [150, 150, 80]", "size_mm = [150000, 150000, 80000]"), "expected at most 500 mm");
}

TEST(GyroFile, ReportsInconsistentBlock) {
  expect_error(with("hole_diameter_mm = 60", "hole_diameter_mm = 78"), "reaches the bores");
  expect_error(with("chamfer_mm = 80", "chamfer_mm = 120"), "between half the width");
  expect_error(with("ring_side_mm = 80", "ring_side_mm = 90"), "corners are outside the mirrors");
  expect_error(with("diameter_mm = 20", "diameter_mm = 60"), "not smaller than the hole");
}

TEST(GyroFile, ReportsThermometerOutsideBlock) {
  expect_error(with("A = [0, 50]", "A = [0, 56]"), "not on the block");
  expect_error(with("G = [0, -50]", "G = [0, -20]"), "not on the block");
}

TEST(GyroFile, ReportsPowerThatContradictsRateTimesVolume) {
  expect_error(with("power_w = 0.784", "power_w = 0.748"), "rate x volume");
}

TEST(GyroFile, ReportsUnknownAndMissingKeys) {
  expect_error(with("hole_diameter_mm", "hole_diametr_mm"), "hole_diametr_mm");
  expect_error(with("[materials.hub] ", "[materials.hob] "), "hub");
}

}  // namespace
}  // namespace gyrotherm::thermal
