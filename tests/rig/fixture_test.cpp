// SPDX-License-Identifier: Apache-2.0
#include "rig/fixture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gyrotherm::rig {
namespace {

constexpr double kOmega = 15.041067;  // °/h

record::AxisInfo placed(const Fixture& fixture, const FixtureVector& direction,
                        const std::optional<double>& direction_uncertainty = {}) {
  record::AxisInfo axis;
  place_axis(fixture, direction, direction_uncertainty, axis);
  return axis;
}

double rate_on(const Fixture& fixture, const FixtureVector& direction) {
  return placed(fixture, direction).earth_rate->value;
}

TEST(Fixture, PointsNorthWestAndUp) {
  const Fixture level{.latitude = 30};
  EXPECT_NEAR(rate_on(level, {1, 0, 0}), kOmega * std::cos(std::numbers::pi / 6), 1e-5);
  EXPECT_NEAR(rate_on(level, {0, 1, 0}), 0, 1e-12);
  EXPECT_NEAR(rate_on(level, {0, 0, 1}), kOmega / 2, 1e-5);
  EXPECT_NEAR(placed(level, {0, 1, 0}).uncertainty.azimuth_deg.value(), -90, 1e-12) << "west";
}

TEST(Fixture, IsTurnedOverEastRaisedAndRolled) {
  const auto x = placed({.latitude = 30, .azimuth = 25, .elevation = 40, .roll = 70}, {1, 0, 0});
  EXPECT_NEAR(x.uncertainty.azimuth_deg.value(), 25, 1e-12);
  EXPECT_NEAR(x.uncertainty.elevation_deg.value(), 40, 1e-12);
  const auto y = placed({.latitude = 30, .roll = 90}, {0, 1, 0});
  EXPECT_NEAR(y.uncertainty.elevation_deg.value(), 90, 1e-9) << "right-handed about x: y goes up";
}

TEST(Fixture, KeepsTheLengthOfTheEarthsRate) {
  const Fixture fixture{.latitude = -47, .azimuth = 123, .elevation = -31, .roll = 12};
  const double x = rate_on(fixture, {1, 0, 0}), y = rate_on(fixture, {0, 1, 0}), z = rate_on(fixture, {0, 0, 1});
  EXPECT_NEAR(std::hypot(x, y, z), kOmega, 1e-5);
}

TEST(Fixture, StandsOnTheEarth) {
  const auto table = TomlTable::parse("latitude = 140\n", "rig.toml");
  (void)read_fixture(*table);
  const auto verdict = table->verdict();
  ASSERT_FALSE(verdict);
  EXPECT_EQ(text(verdict.error()), "rig.toml:1:12: \"latitude\" is 140°, expected -90 to 90, north above 0");
}

/// What the budget makes of an axis' tilt is what turning the fixture makes of its Earth rate.
TEST(Fixture, ATiltOfAnAxisIsAsUncertainAsTheFixture) {
  const Fixture fixture{.latitude = 40,
                        .azimuth = 20,
                        .elevation = 10,
                        .roll = -35,
                        .elevation_uncertainty = 0.02,
                        .roll_uncertainty = 0.05};
  constexpr double kStep = 1e-4;  // degrees
  for (const FixtureVector& direction : {FixtureVector{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, 0, -0.8}}) {
    auto raised = fixture, rolled = fixture;
    raised.elevation += kStep;
    rolled.roll += kStep;
    const double rate = rate_on(fixture, direction);
    const double by_elevation = (rate_on(raised, direction) - rate) / kStep * 0.02,
                 by_roll = (rate_on(rolled, direction) - rate) / kStep * 0.05;
    const auto known = placed(fixture, direction).uncertainty;
    const double el = known.elevation_deg.value();
    const double by_tilt = (earth_rate(40, known.azimuth_deg.value(), el + kStep).value -
                            earth_rate(40, known.azimuth_deg.value(), el).value) /
                           kStep;
    EXPECT_NEAR(std::abs(by_tilt) * known.tilt_uncertainty_deg.value(), std::hypot(by_elevation, by_roll), 1e-6);
  }
}

TEST(Fixture, SaysNothingOfATiltWhereNothingIsSaid) {
  EXPECT_FALSE(placed({.latitude = 40}, {0, 0, 1}).uncertainty.tilt_uncertainty_deg);
  EXPECT_TRUE(placed({.latitude = 40}, {0, 0, 1}, 0.01).uncertainty.tilt_uncertainty_deg);
}

}  // namespace
}  // namespace gyrotherm::rig
