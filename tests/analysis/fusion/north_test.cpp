// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/north.hpp"

#include <Eigen/Geometry>
#include <optional>

#include "analysis/fusion/rest.hpp"
#include "core/quantity.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

TEST(North, IsTheHeadingOfTheFixture) {
  const Gains gains = gains_of(made_of(tetrad_axes(1e-4)));
  for (const double latitude : {-60.0, 0.0, 48.0}) {
    for (double heading = -179; heading <= 180; heading += 13) {
      const Eigen::Vector3d rate = level_fixture(heading).transpose() * earth_rate(latitude);
      const auto north = north_of({rate, gains.covariance}, latitude, {});
      ASSERT_TRUE(north) << text(north.error());
      EXPECT_NEAR(north->heading_deg, heading, 1e-9);
    }
  }
}

TEST(North, IsAsUncertainAsTheEastAxisOverTheHorizontalEarth) {
  const double u = 0.01, latitude = 48, tilt = 0.05;
  Eigen::Matrix3d covariance = Eigen::Vector3d(9, 1, 25).asDiagonal();
  covariance *= u * u;
  const auto at = [&](double heading, double tilt_std_deg) {
    return *north_of({level_fixture(heading).transpose() * earth_rate(latitude), covariance}, latitude,
                     {tilt_std_deg, tilt_std_deg});
  };
  const double horizontal = kEarthRateDegPerHour * std::cos(latitude * kDegree);
  EXPECT_NEAR(at(0, 0).standard_deg, u / horizontal / kDegree, 1e-9) << "the second axis points east";
  EXPECT_NEAR(at(90, 0).standard_deg, 3 * u / horizontal / kDegree, 1e-9) << "the first axis points east";
  EXPECT_NEAR(at(0, 0).expanded_deg / at(0, 0).standard_deg, 1.959964, 1e-5);
  EXPECT_NEAR(at(0, tilt).standard_deg, std::hypot(u / horizontal / kDegree, tilt * std::tan(latitude * kDegree)),
              1e-9);
}

/// 20 seeds of 500 fixtures that stand at random headings, with biases and tilts drawn anew: the mean square of the
/// error over u is 1, and U holds 95 %.
TEST(North, IsWrongAsOftenAsItSays) {
  const double latitude = 55, tilt = 0.03;
  const Geometry geometry = made_of(uneven_axes());
  const Gains gains = gains_of(geometry);
  double squares = 0;
  int inside = 0;
  constexpr int kEach = 500;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int n = 0; n < kEach; ++n) {
      const double heading = 360.0 * n / kEach - 180;
      const Eigen::Vector3d tilted = tilt * kDegree * Eigen::Vector3d(draws.normal(1)(0), draws.normal(1)(0), 0);
      const Eigen::Matrix3d turned =
          Eigen::AngleAxisd(tilted.norm(), tilted.normalized()).toRotationMatrix() * level_fixture(heading);
      const Eigen::VectorXd readings =
          geometry.directions * turned.transpose() * earth_rate(latitude) + draws.with(geometry.covariance);
      const auto north = north_of(fused(gains, readings), latitude, {tilt, tilt});
      ASSERT_TRUE(north) << text(north.error());
      const double error = std::remainder(north->heading_deg - heading, 360);
      squares += std::pow(error / north->standard_deg, 2);
      inside += std::abs(error) <= north->expanded_deg ? 1 : 0;
    }
  }
  constexpr double kCount = kSeeds * kEach;
  EXPECT_NEAR(squares / kCount, 1, 4 * std::sqrt(2 / kCount));
  EXPECT_NEAR(inside / kCount, 0.95, 4 * spread_of_share(0.95, kCount));
}

TEST(North, AgreesWithWhatTheRestSays) {
  const double latitude = 40, u = 0.002;
  const Geometry geometry = made_of(triad_axes(u));
  const Attitude attitude{.azimuth_std_deg = 20, .latitude_deg = latitude};
  const Eigen::Vector3d readings = level_fixture(8).transpose() * earth_rate(latitude);
  const auto north = north_of(fused(gains_of(geometry), readings), latitude, {});
  const auto rest =
      at_rest(geometry, readings, attitude, {Eigen::Vector3d::Zero(), 1e-14 * Eigen::Matrix3d::Identity()});
  ASSERT_TRUE(north && rest);
  EXPECT_NEAR(rest->rotation_rad(2) / kDegree, north->heading_deg, 1e-3);
  EXPECT_NEAR(std::sqrt(rest->rotation_covariance(2, 2)) / kDegree / north->standard_deg, 1, 1e-3);
}

TEST(North, IsRefusedWhereItCannotBeFound) {
  const Eigen::Matrix3d covariance = 1e-4 * Eigen::Matrix3d::Identity();
  const auto kind = [&](const Eigen::Vector3d& rate, double latitude, double tilt) {
    const auto north = north_of({rate, covariance}, latitude, {tilt, 0});
    return north ? std::nullopt : std::optional(north.error().kind);
  };
  EXPECT_EQ(kind(earth_rate(45), 45, 0), std::nullopt);
  EXPECT_EQ(kind(earth_rate(89.7), 89.7, 0), FaultKind::numeric) << "at a pole there is no north";
  EXPECT_EQ(kind(2 * earth_rate(45), 45, 0), FaultKind::numeric) << "it turns";
  EXPECT_EQ(kind(earth_rate(45), 10, 0), FaultKind::numeric) << "another latitude";
  EXPECT_EQ(kind(earth_rate(45), 100, 0), FaultKind::usage);
  EXPECT_EQ(kind(earth_rate(45), 45, -1), FaultKind::usage);
  EXPECT_EQ(kind(Eigen::Vector3d::Constant(std::nan("")), 45, 0), FaultKind::numeric);
}

}  // namespace
}  // namespace gyrotherm::fusion
