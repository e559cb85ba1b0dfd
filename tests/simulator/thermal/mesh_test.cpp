// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "simulator/thermal/assembly.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr double kMm3 = 1e-9;  // m³

/// Octagon minus hole, mm².
const double kPlan = 110 * 110 - 2 * 30 * 30 - std::numbers::pi * 900;
/// Side of a square bore, mm.
const double kBoreSide = std::sqrt(1126.0 / 160);

class EveryEdge : public testing::TestWithParam<double> {};

TEST_P(EveryEdge, GivesBoxesExactVolumes) {
  const auto mesh = make_mesh(shipped_gyro("calibrated"), GetParam());
  const auto mm3 = [&](GyroPart part) { return part_volume(mesh, part) / kMm3; };
  EXPECT_NEAR(mm3(GyroPart::gain_left), 563, 1e-6);
  EXPECT_NEAR(mm3(GyroPart::gain_right), 563, 1e-6);
  EXPECT_NEAR(mm3(GyroPart::passive_bore), 1126, 1e-6);
  EXPECT_NEAR(mm3(GyroPart::ballast_left), 295, 1e-6);
  EXPECT_NEAR(mm3(GyroPart::ballast_right), 295, 1e-6);
  EXPECT_NEAR(mm3(GyroPart::preamplifier), 35'000, 1e-5);
  EXPECT_NEAR(mm3(GyroPart::cathode), 6'400, 1e-6);
  EXPECT_NEAR(mm3(GyroPart::shell), 150 * 150 * 80 - 144 * 144 * 74, 1e-4);
}

TEST_P(EveryEdge, GivesSlantedAndRoundPartsVolumesWithinRounding) {
  const auto mesh = make_mesh(shipped_gyro("calibrated"), GetParam());
  const auto mm3 = [&](GyroPart part) { return part_volume(mesh, part) / kMm3; };
  const double hub = std::numbers::pi * 100 * (80.0 / 2 + 15 - 3);
  const double dither = std::numbers::pi * (900 - 100) * 30;
  // At each corner of the ring, half of a cube of the bores is cut out of the mirror instead of the block.
  const double bores_in_mirrors = 4 * kBoreSide * kBoreSide * kBoreSide / 2;
  const double block = kPlan * 25 - (2252 - bores_in_mirrors);
  EXPECT_NEAR(mm3(GyroPart::hub) / hub, 1, 3e-3);
  EXPECT_NEAR(mm3(GyroPart::dither) / dither, 1, 2e-3);
  EXPECT_NEAR(mm3(GyroPart::block) / block, 1, 5e-4);
  for (const auto part : {GyroPart::mirror_b, GyroPart::mirror_c, GyroPart::mirror_f, GyroPart::mirror_h})
    EXPECT_NEAR(mm3(part) / (24 * 24 * 6 - bores_in_mirrors / 4), 1, 5e-3);
}

TEST_P(EveryEdge, FillsCabinetWithParts) {
  const auto mesh = make_mesh(shipped_gyro("calibrated"), GetParam());
  double sum = 0;
  for (std::size_t part = 0; part < kGyroParts; ++part) sum += part_volume(mesh, static_cast<GyroPart>(part));
  EXPECT_NEAR(sum / kMm3, 150 * 150 * 80, 1e-4);
}

/// Returns the area of the film, mm². It consists of top and bottom, including mirrors, and of the side walls. Mirrors,
/// cathode and ballasts cover part of the side walls and add their own surface.
double true_film_area_mm2(const GyroGeometry& g) {
  const double walls = (4 * 50 + 4 * 30 * std::numbers::sqrt2) * 25;
  // The front replaces the area covered by the back.
  const double mirrors = 4 * 2 * (24 + g.mirror_height) * g.mirror_thickness;
  const double ballast = std::cbrt(295.0);
  const double boxes = 2 * 4 * ballast * ballast + 2 * (20 + g.cathode[2]) * 16;
  return 2 * kPlan + walls + mirrors + boxes;
}

double film_area_mm2(const GyroMesh& mesh) { return assemble_film_ambient(mesh).sum() * 1e6; }

void expect_film_area_of_block(double edge_mm) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  EXPECT_NEAR(film_area_mm2(make_mesh(model, edge_mm)), true_film_area_mm2(model.geometry), 1e-6);
}

TEST_P(EveryEdge, GivesFilmOfBlockTrueArea) { expect_film_area_of_block(GetParam()); }

/// On a 45° face, the strip above the mirror is five bricks behind the face of the mirror.
TEST(Mesh, GivesFilmTrueAreaWithSmallBricks) { expect_film_area_of_block(1.1); }

/// Returns a block with mirrors that extend by `excess_mm` beyond a level of grid lines, half above and half below.
GyroModel block_with_mirrors(double excess_mm, double thickness_mm) {
  auto model = shipped_gyro("calibrated");
  model.mode = GyroMode::block;
  model.geometry.cathode[2] = 15;  // has lines on its faces
  model.geometry.mirror_height = 15 + excess_mm;
  model.geometry.mirror_thickness = thickness_mm;
  return model;
}

/// Only the excess of 0.1 mm is more than half a step of the shares of a brick. The walls of mirrors of 60 mm are up to
/// ten bricks from the block.
TEST(Mesh, HasNoEmptyBricksWhenPartsTouchLayer) {
  constexpr double kEdge_mm = 4.6;
  for (const double thickness_mm : {6.0, 60.0}) {
    for (const double excess_mm : {1e-4, 1e-3, 3e-3, 0.1}) {
      SCOPED_TRACE(excess_mm);
      const auto model = block_with_mirrors(excess_mm, thickness_mm);
      const auto mesh = make_mesh(model, kEdge_mm);
      for (std::size_t number = 1; number < mesh.classes.size(); ++number)
        EXPECT_FALSE(mesh.classes[number].shares.empty()) << number;
      EXPECT_FALSE(mesh.film.empty());
      for (const FilmFace& face : mesh.film) EXPECT_NE(mesh.bricks[face.brick], 0) << face.brick;
      EXPECT_TRUE(std::isfinite(assemble_capacity(model, mesh).sum()));
      EXPECT_NEAR(film_area_mm2(mesh), true_film_area_mm2(model.geometry), 1e-6);
    }
  }
}

TEST_P(EveryEdge, KeepsVolumeOfBlockInConsolidation) {
  auto model = shipped_gyro("calibrated");
  const double full = part_volume(make_mesh(model, GetParam()), GyroPart::block);
  model.mode = GyroMode::block;
  EXPECT_NEAR(part_volume(make_mesh(model, GetParam()), GyroPart::block) / full, 1, 5e-4);
}

INSTANTIATE_TEST_SUITE_P(Mesh, EveryEdge, testing::Values(9.0, 4.6, 2.9));

TEST(Mesh, HasExpectedNumbersOfNodes) {
  const auto model = shipped_gyro("calibrated");
  EXPECT_EQ(make_mesh(model, MeshSize::coarse).node_count, 98'989U);
  EXPECT_EQ(make_mesh(model, MeshSize::medium).node_count, 308'831U);
}

TEST(Mesh, HasLinesOnFacesOfBoxes) {
  const auto mesh = make_mesh(shipped_gyro("calibrated"), MeshSize::coarse);
  const auto has = [](const std::vector<double>& lines, double mm) {
    return std::ranges::any_of(lines, [&](double line) { return std::abs(line - 1e-3 * mm) < 1e-9; });
  };
  for (const double x : {0.0, 3.0, 20.0, 45.0, 75.0, 130.0, 147.0}) EXPECT_TRUE(has(mesh.x, x)) << x;
  for (const double z : {3.0, 15.0, 27.5, 52.5, 55.0, 77.0}) EXPECT_TRUE(has(mesh.z, z)) << z;
}

}  // namespace
}  // namespace gyrotherm::thermal
