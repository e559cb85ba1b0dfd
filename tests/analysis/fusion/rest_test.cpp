// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/rest.hpp"

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

constexpr double kLatitude_deg = 48;

BiasPrior unknown_biases(Eigen::Index axes, double std) {
  return {Eigen::VectorXd::Zero(axes), std * std * Eigen::MatrixXd::Identity(axes, axes)};
}

/// Returns the readings of a fixture at rest that is rotated by `angle` (rad, rotation vector) from its nominal
/// attitude and has these biases.
Eigen::VectorXd fixture_readings(const Geometry& geometry, const Attitude& attitude, const Eigen::Vector3d& angle,
                                 const Eigen::VectorXd& bias) {
  const double size = angle.norm();
  const Eigen::Matrix3d turned = (size == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                            : Eigen::AngleAxisd(size, angle / size).toRotationMatrix()) *
                                 attitude.to_local;
  return geometry.directions * turned.transpose() * earth_rate(attitude.latitude_deg) + bias;
}

TEST(Rest, HasEarthRate) {
  EXPECT_NEAR(kEarthRateDegPerHour, 7.292115e-5 * 3600 / kDegree, 1e-5);
  EXPECT_TRUE(earth_rate(0).isApprox(Eigen::Vector3d(kEarthRateDegPerHour, 0, 0)));
  EXPECT_TRUE(earth_rate(30).isApprox(kEarthRateDegPerHour * Eigen::Vector3d(std::sqrt(0.75), 0, -0.5)));
  EXPECT_TRUE(earth_rate(-90).isApprox(Eigen::Vector3d(0, 0, kEarthRateDegPerHour), 1e-9)) << "up, at the south pole";
}

TEST(Rest, RecoversBiasesForKnownAttitude) {
  const Geometry geometry = valid_geometry(tetrad_axes(1e-4));
  const Attitude attitude{.to_local = level_fixture(30), .latitude_deg = kLatitude_deg};
  const Eigen::Vector4d bias(0.01, -0.02, 0.03, 0.005);
  const auto estimate = estimate_at_rest(geometry, fixture_readings(geometry, attitude, Eigen::Vector3d::Zero(), bias),
                                         attitude, unknown_biases(4, 1));
  ASSERT_TRUE(estimate) << text(estimate.error());
  EXPECT_TRUE(estimate->bias_deg_per_h.isApprox(bias, 1e-7)) << "the weak prior hardly shifts them";
  EXPECT_EQ(estimate->rotation_rad.norm(), 0) << "the attitude is known";
  EXPECT_NEAR(std::sqrt(estimate->bias_covariance(0, 0)), 1e-4, 1e-9);
  EXPECT_LE(estimate->iterations, 2);
}

/// The east axis measures bias − Ω cos φ ψ_down − Ω sin φ ψ_north. If its bias has the uncertainty u and the tilt is
/// known, the azimuth has the uncertainty u/(Ω cos φ). A tilt uncertainty u_t adds u_t tan φ as a root sum of squares.
TEST(Rest, HasAzimuthUncertaintyOfEastAxisBias) {
  const double u = 0.003, tilt = 0.02;
  const Geometry geometry = valid_geometry(triad_axes(1e-6));
  const double horizontal = kEarthRateDegPerHour * std::cos(kLatitude_deg * kDegree);
  for (const double tilt_std_deg : {0.0, tilt}) {
    const Attitude attitude{.tilt_std_deg = tilt_std_deg, .azimuth_std_deg = 3, .latitude_deg = kLatitude_deg};
    const auto estimate =
        estimate_at_rest(geometry, fixture_readings(geometry, attitude, {0, 0, 0.01}, Eigen::Vector3d::Zero()),
                         attitude, unknown_biases(3, u));
    ASSERT_TRUE(estimate);
    const double expected = std::hypot(u / horizontal, tilt_std_deg * kDegree * std::tan(kLatitude_deg * kDegree));
    EXPECT_NEAR(std::sqrt(estimate->rotation_covariance(2, 2)) / expected, 1, 1e-3);
    EXPECT_NEAR(estimate->rotation_rad(2), 0.01, 1e-5);
  }
}

TEST(Rest, CannotObserveRotationAboutEarthAxis) {
  const Geometry geometry = valid_geometry(dodecahedron_axes(1e-6));
  const Attitude attitude{.tilt_std_deg = 0.5, .azimuth_std_deg = 0.5, .latitude_deg = kLatitude_deg};
  const auto estimate = estimate_at_rest(
      geometry, fixture_readings(geometry, attitude, Eigen::Vector3d::Zero(), Eigen::VectorXd::Zero(6)), attitude,
      unknown_biases(6, 1e-5));
  ASSERT_TRUE(estimate);
  const Eigen::Vector3d axis = earth_rate(kLatitude_deg).normalized(), across = Eigen::Vector3d(0, 1, 0);
  EXPECT_NEAR(std::sqrt(axis.dot(estimate->rotation_covariance * axis)), 0.5 * kDegree, 1e-6);
  EXPECT_LT(std::sqrt(across.dot(estimate->rotation_covariance * across)), 2e-6);
}

/// The numerical derivative of the minimised sum of squares vanishes at the solution.
TEST(Rest, MaximisesPosteriorOfBiasesAndAngles) {
  const Geometry geometry = valid_geometry(uneven_axes());
  const Attitude attitude{.to_local = level_fixture(77),
                          .tilt_std_deg = 4,
                          .azimuth_std_deg = 15,
                          .latitude_deg = kLatitude_deg,
                          .latitude_std_deg = 1};
  const BiasPrior prior{Eigen::VectorXd::Constant(6, 0.01),
                        4e-4 * Eigen::MatrixXd::Identity(6, 6) + 1e-4 * Eigen::MatrixXd::Ones(6, 6)};
  const Eigen::Vector3d stds(4, std::hypot(4, 1), 15);
  const auto cost = [&](const Eigen::VectorXd& readings, const Eigen::VectorXd& x) {
    const Eigen::VectorXd bias = x.head(6) - prior.mean_deg_per_h;
    const Eigen::VectorXd left = readings - fixture_readings(geometry, attitude, x.tail(3), x.head(6));
    return left.dot(geometry.covariance.ldlt().solve(left)) + bias.dot(prior.covariance.ldlt().solve(bias)) +
           x.tail(3).cwiseQuotient(stds * kDegree).squaredNorm();
  };
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    const Eigen::Vector3d angle = kDegree * stds.cwiseProduct(draws.normal(3));
    const Eigen::VectorXd readings =
        fixture_readings(geometry, attitude, angle, draws.correlated_normal(prior.covariance)) +
        draws.correlated_normal(geometry.covariance);
    const auto estimate = estimate_at_rest(geometry, readings, attitude, prior);
    ASSERT_TRUE(estimate) << text(estimate.error());
    Eigen::VectorXd x(9);
    x << estimate->bias_deg_per_h, estimate->rotation_rad;
    const double least = cost(readings, x);
    EXPECT_NEAR(estimate->statistic, least, 1e-6 * (1 + least)) << "seed " << seed;
    for (Eigen::Index i = 0; i < 9; ++i) {
      const double step = i < 6 ? 1e-5 : 1e-7;
      const Eigen::VectorXd more = x + step * Eigen::VectorXd::Unit(9, i),
                            less = x - step * Eigen::VectorXd::Unit(9, i);
      const double slope = cost(readings, more) - cost(readings, less), bend = cost(readings, more) - least;
      EXPECT_LT(std::abs(slope), 1e-3 * std::abs(bend) + 1e-8) << "seed " << seed << ", " << i;
    }
  }
}

/// Two statistics follow χ²: the errors weighted by the inverse of their covariance, and the residual of priors and
/// readings.
TEST(Rest, HasErrorsOfStatedCovariance) {
  const Geometry geometry = valid_geometry(tetrad_axes(0.001));
  const Attitude attitude{
      .to_local = level_fixture(120), .tilt_std_deg = 0.02, .azimuth_std_deg = 0.5, .latitude_deg = kLatitude_deg};
  const BiasPrior prior = unknown_biases(4, 0.004);
  const Eigen::Vector3d stds(0.02, 0.02, 0.5);
  constexpr int kEach = 200;
  double errors = 0, statistics = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int n = 0; n < kEach; ++n) {
      const Eigen::Vector3d angle = kDegree * stds.cwiseProduct(draws.normal(3));
      const Eigen::VectorXd bias = draws.correlated_normal(prior.covariance);
      const auto estimate = estimate_at_rest(
          geometry, fixture_readings(geometry, attitude, angle, bias) + draws.correlated_normal(geometry.covariance),
          attitude, prior);
      ASSERT_TRUE(estimate);
      Eigen::VectorXd error(7);
      error << estimate->bias_deg_per_h - bias, estimate->rotation_rad - angle;
      Eigen::MatrixXd covariance(7, 7);
      covariance << estimate->bias_covariance, estimate->cross_covariance, estimate->cross_covariance.transpose(),
          estimate->rotation_covariance;
      errors += error.dot(covariance.ldlt().solve(error));
      statistics += estimate->statistic;
    }
  }
  constexpr double kCount = kSeeds * kEach;
  EXPECT_NEAR(errors / kCount, 7, 4 * std::sqrt(2 * 7 / kCount));
  EXPECT_NEAR(statistics / kCount, 4, 4 * std::sqrt(2 * 4 / kCount));
}

TEST(Rest, TestsThreeAxesWithoutParity) {
  const Geometry geometry = valid_geometry(triad_axes(0.001));
  const Attitude attitude{.tilt_std_deg = 0.01, .azimuth_std_deg = 0.02, .latitude_deg = kLatitude_deg};
  const BiasPrior prior = unknown_biases(3, 0.002);
  const auto rest = rest_test(geometry, attitude, prior);
  ASSERT_TRUE(rest);
  int alarms = 0, named = 0;
  constexpr int kEach = 1000;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int n = 0; n < kEach; ++n) {
      const Eigen::Vector3d angle = kDegree * Eigen::Vector3d(0.01, 0.01, 0.02).cwiseProduct(draws.normal(3));
      Eigen::VectorXd readings =
          fixture_readings(geometry, attitude, angle, draws.correlated_normal(prior.covariance)) +
          draws.correlated_normal(geometry.covariance);
      const auto examined = [&](double probability) {
        return examine(rest->test, rest->whitening * (readings - rest->expected_deg_per_h),
                       {.false_alarm_probability = probability});
      };
      alarms += examined(0.01).fault ? 1 : 0;
      readings(n % 3) += 0.06;
      const Finding finding = examined(1e-6);
      named += finding.isolation && finding.isolation->candidate == n % 3 ? 1 : 0;
    }
  }
  constexpr double kCount = kSeeds * kEach;
  EXPECT_NEAR(alarms / kCount, 0.01, 4 * relative_frequency_std(0.01, kCount));
  EXPECT_GT(named, 0.99 * kCount);
}

/// Readings that contradict the Earth rate let the angle approach its value slowly. The angle itself is above 0.1 rad.
TEST(Rest, ReportsLastCorrectionWhenAttitudeDoesNotConverge) {
  const Geometry geometry = valid_geometry(triad_axes(1e-3));
  const Attitude attitude{.tilt_std_deg = 60, .azimuth_std_deg = 120, .latitude_deg = kLatitude_deg};
  for (const Eigen::Vector3d& readings :
       {Eigen::Vector3d(-3.095, -0.315, 5.495), {-1.793, 0.672, 5.639}, {6.982, -7.781, 4.378}}) {
    const auto estimate = estimate_at_rest(geometry, readings, attitude, unknown_biases(3, 0.01));
    ASSERT_FALSE(estimate);
    EXPECT_EQ(estimate.error().kind, FaultKind::numeric);
    const std::string label = "last correction ";
    const auto at = estimate.error().what.find(label);
    ASSERT_NE(at, std::string::npos) << estimate.error().what;
    const double correction = std::stod(estimate.error().what.substr(at + label.size()));
    EXPECT_GT(correction, 0);
    EXPECT_LT(correction, 0.01) << estimate.error().what;
  }
}

TEST(Rest, RejectsInvalidAttitudeOrPrior) {
  const Geometry geometry = valid_geometry(triad_axes(0.001));
  const Eigen::Vector3d readings(1, 2, 3);
  const auto refused = [&](const Attitude& attitude, const BiasPrior& prior) {
    const auto estimate = estimate_at_rest(geometry, readings, attitude, prior);
    return !estimate && estimate.error().kind == FaultKind::usage && !rest_test(geometry, attitude, prior);
  };
  const BiasPrior prior = unknown_biases(3, 0.1);
  EXPECT_TRUE(refused({}, unknown_biases(4, 0.1)));
  EXPECT_TRUE(refused({.tilt_std_deg = -1}, prior));
  EXPECT_TRUE(refused({.latitude_deg = 91}, prior));
  EXPECT_TRUE(refused({.to_local = Eigen::Vector3d(1, 1, -1).asDiagonal()}, prior)) << "a mirror";
  EXPECT_TRUE(refused({.to_local = 2 * Eigen::Matrix3d::Identity()}, prior));
  EXPECT_FALSE(estimate_at_rest(geometry, Eigen::Vector3d(1, std::nan(""), 3), {}, prior));
}

TEST(North, EqualsHeadingOfFixture) {
  const Gains gains = compute_gains(valid_geometry(tetrad_axes(1e-4)));
  for (const double latitude : {-60.0, 0.0, 48.0}) {
    for (double heading = -179; heading <= 180; heading += 13) {
      const Eigen::Vector3d rate = level_fixture(heading).transpose() * earth_rate(latitude);
      const auto north = find_north({rate, gains.covariance}, latitude, {});
      ASSERT_TRUE(north) << text(north.error());
      EXPECT_NEAR(north->heading_deg, heading, 1e-9);
    }
  }
}

TEST(North, HasHeadingOf180DegreesForAxisThatPointsSouth) {
  const Eigen::Matrix3d covariance = 1e-8 * Eigen::Matrix3d::Identity();
  for (const double across : {0.0, -0.0, 1e-30, -1e-30}) {
    const auto north = find_north({Eigen::Vector3d(-kEarthRateDegPerHour, across, 0), covariance}, 0, {});
    ASSERT_TRUE(north) << text(north.error());
    EXPECT_EQ(north->heading_deg, 180) << across;
  }
}

TEST(North, HasUncertaintyOfEastAxisPerHorizontalEarthRate) {
  const double u = 0.01, latitude = 48, tilt = 0.05;
  Eigen::Matrix3d covariance = Eigen::Vector3d(9, 1, 25).asDiagonal();
  covariance *= u * u;
  const auto at = [&](double heading, double tilt_std_deg) {
    return *find_north({level_fixture(heading).transpose() * earth_rate(latitude), covariance}, latitude,
                       {tilt_std_deg, tilt_std_deg});
  };
  const double horizontal = kEarthRateDegPerHour * std::cos(latitude * kDegree);
  EXPECT_NEAR(at(0, 0).standard_deg, u / horizontal / kDegree, 1e-9) << "the second axis points east";
  EXPECT_NEAR(at(90, 0).standard_deg, 3 * u / horizontal / kDegree, 1e-9) << "the first axis points east";
  EXPECT_NEAR(at(0, 0).expanded_deg / at(0, 0).standard_deg, 1.959964, 1e-5);
  EXPECT_NEAR(at(0, tilt).standard_deg, std::hypot(u / horizontal / kDegree, tilt * std::tan(latitude * kDegree)),
              1e-9);
}

/// 20 seeds of 500 fixtures, with headings all around and random noise and tilts. The mean square of error / u is 1,
/// and 95 % of the errors are within U.
TEST(North, HasErrorsOfStatedUncertainty) {
  const double latitude = 55, tilt = 0.03;
  const Geometry geometry = valid_geometry(uneven_axes());
  const Gains gains = compute_gains(geometry);
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
      const Eigen::VectorXd readings = geometry.directions * turned.transpose() * earth_rate(latitude) +
                                       draws.correlated_normal(geometry.covariance);
      const auto north = find_north(fuse_readings(gains, readings), latitude, {tilt, tilt});
      ASSERT_TRUE(north) << text(north.error());
      const double error = std::remainder(north->heading_deg - heading, 360);
      squares += std::pow(error / north->standard_deg, 2);
      inside += std::abs(error) <= north->expanded_deg ? 1 : 0;
    }
  }
  constexpr double kCount = kSeeds * kEach;
  EXPECT_NEAR(squares / kCount, 1, 4 * std::sqrt(2 / kCount));
  EXPECT_NEAR(inside / kCount, 0.95, 4 * relative_frequency_std(0.95, kCount));
}

TEST(North, AgreesWithRestEstimate) {
  const double latitude = 40, u = 0.002;
  const Geometry geometry = valid_geometry(triad_axes(u));
  const Attitude attitude{.azimuth_std_deg = 20, .latitude_deg = latitude};
  const Eigen::Vector3d readings = level_fixture(8).transpose() * earth_rate(latitude);
  const auto north = find_north(fuse_readings(compute_gains(geometry), readings), latitude, {});
  const auto rest =
      estimate_at_rest(geometry, readings, attitude, {Eigen::Vector3d::Zero(), 1e-14 * Eigen::Matrix3d::Identity()});
  ASSERT_TRUE(north && rest);
  EXPECT_NEAR(rest->rotation_rad(2) / kDegree, north->heading_deg, 1e-3);
  EXPECT_NEAR(std::sqrt(rest->rotation_covariance(2, 2)) / kDegree / north->standard_deg, 1, 1e-3);
}

TEST(North, IsRefusedWhenNotObservable) {
  const Eigen::Matrix3d covariance = 1e-4 * Eigen::Matrix3d::Identity();
  const auto kind = [&](const Eigen::Vector3d& rate, double latitude, double tilt) {
    const auto north = find_north({rate, covariance}, latitude, {tilt, 0});
    return north ? std::nullopt : std::optional(north.error().kind);
  };
  EXPECT_EQ(kind(earth_rate(45), 45, 0), std::nullopt);
  EXPECT_EQ(kind(earth_rate(89.7), 89.7, 0), FaultKind::numeric) << "heading is undefined near the pole";
  EXPECT_EQ(kind(2 * earth_rate(45), 45, 0), FaultKind::numeric) << "the fixture rotates";
  EXPECT_EQ(kind(earth_rate(45), 10, 0), FaultKind::numeric) << "another latitude";
  EXPECT_EQ(kind(earth_rate(45), 100, 0), FaultKind::usage);
  EXPECT_EQ(kind(earth_rate(45), 45, -1), FaultKind::usage);
  EXPECT_EQ(kind(Eigen::Vector3d::Constant(std::nan("")), 45, 0), FaultKind::numeric);
}

}  // namespace
}  // namespace gyrotherm::fusion
