// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/fixture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gyrotherm::rig {
namespace {

constexpr double kOmega = 15.041067;  // °/h

record::AxisInfo make_axis_info(const Fixture& fixture, const FixtureVector& direction,
                                const std::optional<double>& direction_uncertainty = {}) {
  record::AxisInfo axis;
  orient_axis(fixture, direction, direction_uncertainty, axis);
  return axis;
}

double earth_rate_on(const Fixture& fixture, const FixtureVector& direction) {
  return make_axis_info(fixture, direction).earth_rate->value;
}

TEST(Fixture, PointsNorthWestAndUp) {
  const Fixture level{.latitude = 30};
  EXPECT_NEAR(earth_rate_on(level, {1, 0, 0}), kOmega * std::cos(std::numbers::pi / 6), 1e-5);
  EXPECT_NEAR(earth_rate_on(level, {0, 1, 0}), 0, 1e-12);
  EXPECT_NEAR(earth_rate_on(level, {0, 0, 1}), kOmega / 2, 1e-5);
  EXPECT_NEAR(make_axis_info(level, {0, 1, 0}).uncertainty.azimuth_deg.value(), -90, 1e-12) << "west";
}

TEST(Fixture, AppliesTurnElevationAndRoll) {
  const auto x = make_axis_info({.latitude = 30, .azimuth = 25, .elevation = 40, .roll = 70}, {1, 0, 0});
  EXPECT_NEAR(x.uncertainty.azimuth_deg.value(), 25, 1e-12);
  EXPECT_NEAR(x.uncertainty.elevation_deg.value(), 40, 1e-12);
  const auto y = make_axis_info({.latitude = 30, .roll = 90}, {0, 1, 0});
  EXPECT_NEAR(y.uncertainty.elevation_deg.value(), 90, 1e-9) << "right-handed about x: y goes up";
}

TEST(Fixture, KeepsMagnitudeOfEarthRate) {
  const Fixture fixture{.latitude = -47, .azimuth = 123, .elevation = -31, .roll = 12};
  const double x = earth_rate_on(fixture, {1, 0, 0}), y = earth_rate_on(fixture, {0, 1, 0}),
               z = earth_rate_on(fixture, {0, 0, 1});
  EXPECT_NEAR(std::hypot(x, y, z), kOmega, 1e-5);
}

TEST(Fixture, RequiresLatitudeOnEarth) {
  const auto table = TomlTable::parse("latitude = 140\n", "rig.toml");
  (void)read_fixture(*table);
  const auto verdict = table->verdict();
  ASSERT_FALSE(verdict);
  EXPECT_EQ(text(verdict.error()), "rig.toml:1:12: \"latitude\" is 140°, expected -90 to 90, north positive");
}

/// The uncertainty of one axis cannot represent the angles of a fixture: here the tilt of axis a alone would be 0.3°.
TEST(Fixture, KeepsEachAngleOfFile) {
  const Fixture fixture{.latitude = 31.2, .azimuth = 12, .elevation_uncertainty = 0.01, .roll_uncertainty = 0.02};
  const auto known = make_axis_info(fixture, {0.6, 0, 0.8}, 0.005).uncertainty;
  EXPECT_EQ(known.fixture_azimuth_deg, 12);
  EXPECT_EQ(known.fixture_elevation_deg, 0);
  EXPECT_EQ(known.elevation_uncertainty_deg, 0.01);
  EXPECT_EQ(known.roll_uncertainty_deg, 0.02);
  EXPECT_EQ(known.direction_uncertainty_deg, 0.005);
  EXPECT_FALSE(known.tilt_uncertainty_deg);
}

TEST(Fixture, LeavesUnstatedAnglesUnknown) {
  const auto known = make_axis_info({.latitude = 40, .roll_uncertainty = 0.01}, {0, 0, 1}).uncertainty;
  EXPECT_FALSE(known.elevation_uncertainty_deg);
  EXPECT_FALSE(known.direction_uncertainty_deg);
  EXPECT_EQ(known.roll_uncertainty_deg, 0.01);
}

}  // namespace
}  // namespace gyrotherm::rig
