// SPDX-License-Identifier: Apache-2.0
/// Compares the expanded uncertainty of a heading with a Monte Carlo simulation of all uncertain quantities, at many
/// latitudes and azimuths.
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "analysis/model/fused_run.hpp"
#include "analysis/model/uncertainty.hpp"
#include "core/quantity.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::model {
namespace {

using fusion::Draws;
using fusion::kDegree;

#ifdef GYROTHERM_NIGHTLY
constexpr int kPoses = 200, kDrawsOfPose = 10000;
#else
constexpr int kPoses = 40, kDrawsOfPose = 2500;
#endif

/// Standard deviations of the turn-on bias and of the white noise over one second.
constexpr double kStart_deg_per_h = 0.0005, kWhite_deg_per_h = 0.01;

/// Angles of a fixture in degrees, or their errors.
struct Pose {
  double latitude{}, azimuth{}, elevation{}, roll{};
};

/// Returns the rotation from the fixture to north, west and up: roll about x, then elevation, then azimuth.
Eigen::Matrix3d rotation_to_room(const Pose& pose) {
  return (Eigen::AngleAxisd(-pose.azimuth * kDegree, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(-pose.elevation * kDegree, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(pose.roll * kDegree, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

/// Returns the Earth rate in the coordinates of the fixture, °/h.
Eigen::Vector3d earth_in(const Pose& pose) {
  const double phi = pose.latitude * kDegree;
  return kEarthRateDegPerHour * rotation_to_room(pose).transpose() * Eigen::Vector3d(std::cos(phi), 0, std::sin(phi));
}

/// Standard uncertainties of the recorded angles, and of the direction of an axis in the fixture.
constexpr Pose kUncertainty{.latitude = 0.001, .azimuth = 0.02, .elevation = 0.01, .roll = 0.015};
constexpr double kDirection_deg = 0.008;

/// Returns the recorded angles of an axis and their uncertainties.
record::GyroUncertainty recorded_angles(const Pose& pose, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d room = rotation_to_room(pose) * direction;
  return {.latitude_deg = pose.latitude,
          .azimuth_deg = std::atan2(-room(1), room(0)) / kDegree,
          .elevation_deg = std::asin(std::clamp(room(2), -1.0, 1.0)) / kDegree,
          .latitude_uncertainty_deg = kUncertainty.latitude,
          .azimuth_uncertainty_deg = kUncertainty.azimuth,
          .fixture_azimuth_deg = pose.azimuth,
          .fixture_elevation_deg = pose.elevation,
          .elevation_uncertainty_deg = kUncertainty.elevation,
          .roll_uncertainty_deg = kUncertainty.roll,
          .direction_uncertainty_deg = kDirection_deg,
          .scale_factor_uncertainty_ppm = 0};
}

/// Returns axes without bias, which measure only the Earth rate. Each has a model that predicts 0 and the budget of its
/// record.
std::vector<CompensatedAxis> axes_at(const Pose& pose, const std::vector<fusion::InputAxis>& axes) {
  constexpr Eigen::Index kSeconds = 1000;
  std::vector<CompensatedAxis> all;
  for (const fusion::InputAxis& axis : axes) {
    data::Dataset dataset;
    dataset.of = {.unit = axis.name};
    dataset.thermometers = {"A"};
    dataset.direction = {axis.direction(0), axis.direction(1), axis.direction(2)};
    dataset.gyro_uncertainty = recorded_angles(pose, axis.direction);
    dataset.earth_rate_deg_per_h = earth_in(pose).dot(axis.direction);
    dataset.segments = {{}};
    dataset.segments.front().hold = true;
    dataset.time_s = Eigen::VectorXd::LinSpaced(kSeconds, 0, kSeconds - 1);
    dataset.temperature_c = Eigen::MatrixXd::Constant(kSeconds, 1, 20);
    dataset.bias_deg_per_h = Eigen::VectorXd::Zero(kSeconds);
    dataset.segment = Eigen::VectorXi::Zero(kSeconds);
    dataset.cycle = Eigen::VectorXi::Constant(kSeconds, -1);
    dataset.set_point_c = Eigen::VectorXd::Constant(kSeconds, 20);
    Model model;
    model.method = "linear";
    model.terms = {data::temperature_term("A")};
    model.scaling = {Eigen::RowVectorXd::Constant(1, 20), Eigen::RowVectorXd::Constant(1, 1)};
    model.target_std_deg_per_h = 1;
    model.function = methods::LinearModel{.weights = Eigen::VectorXd::Zero(1), .b = 0};
    model.input_min = Eigen::RowVectorXd::Constant(1, -50);
    model.input_max = Eigen::RowVectorXd::Constant(1, 70);
    model.residual_noise = {.angle_random_walk_deg_per_sqrt_h = kWhite_deg_per_h / 60,
                            .start_deg_per_h = kStart_deg_per_h};
    Budget budget{.averaging_s = kSecondsPerHour,
                  .rows = {{.source = Source::angle_random_walk, .standard_uncertainty = kWhite_deg_per_h / 60},
                           {.source = Source::turn_on, .standard_uncertainty = kStart_deg_per_h}}};
    for (BudgetRow& row : budget_of_earth_rate(dataset)) budget.rows.push_back(std::move(row));
    model.uncertainty = {.budget = std::move(budget), .sensitivities = {}};
    all.push_back({std::move(dataset), std::move(model)});
  }
  return all;
}

/// Draws a pose with normally distributed deviations from `pose`. `std` contains their standard deviations.
Pose drawn_pose(const Pose& pose, const Pose& std, Draws& draws) {
  const Eigen::VectorXd deviation = draws.normal(4);
  return {.latitude = pose.latitude + std.latitude * deviation(0),
          .azimuth = pose.azimuth + std.azimuth * deviation(1),
          .elevation = pose.elevation + std.elevation * deviation(2),
          .roll = pose.roll + std.roll * deviation(3)};
}

/// Returns the standard deviation of the heading error in a Monte Carlo simulation, degrees. In training, the fixture
/// and its axes deviate from the recorded pose. In use, the fixture is mounted again with its nominal heading.
double drawn_std_deg(const Pose& pose, const std::vector<fusion::InputAxis>& axes, double mean_s, Draws& draws) {
  const auto count = std::ssize(axes);
  Eigen::MatrixX3d directions(count, 3);
  for (Eigen::Index a = 0; a < count; ++a) directions.row(a) = axes[static_cast<std::size_t>(a)].direction.transpose();
  const Eigen::MatrixXd to_rate = (directions.transpose() * directions).inverse() * directions.transpose();
  const Pose in_use{.elevation = kUncertainty.elevation, .roll = kUncertainty.roll};
  double squares = 0;
  for (int draw = 0; draw < kDrawsOfPose; ++draw) {
    const Pose trained = drawn_pose(pose, kUncertainty, draws), used = drawn_pose(pose, in_use, draws);
    Eigen::VectorXd readings = directions * earth_in(used);
    const Eigen::VectorXd noise =
        std::hypot(kStart_deg_per_h, kWhite_deg_per_h / std::sqrt(mean_s)) * draws.normal(count);
    for (Eigen::Index a = 0; a < count; ++a) {
      const Eigen::Vector3d nominal = directions.row(a).transpose();
      // A rotation has two components across the axis. Each gets half of the variance of the direction.
      const Eigen::Vector3d turn = kDirection_deg * kDegree / std::sqrt(2) * draws.normal(3);
      const Eigen::Vector3d actual = nominal + turn.cross(nominal);
      const double learnt = earth_in(trained).dot(actual) - earth_in(pose).dot(nominal);
      readings(a) += noise(a) - learnt;
    }
    const Eigen::Vector3d room = rotation_to_room({.azimuth = pose.azimuth}) * (to_rate * readings);
    squares += std::pow(std::atan2(room(1), room(0)) / kDegree, 2);
  }
  return std::sqrt(squares / kDrawsOfPose);
}

/// Requires that the stated uncertainty of the heading agrees with the simulated one within 10 % in every pose.
void expect_simulated_uncertainty(const std::vector<fusion::InputAxis>& axes, std::uint64_t seed) {
  Draws draws(seed);
  int compared = 0;
  for (int n = 0; n < kPoses; ++n) {
    const Pose pose{.latitude = 65 * (2.0 * n / (kPoses - 1) - 1), .azimuth = 360 * std::fmod(0.618034 * n, 1) - 180};
    const auto fused = compensate_axes(axes_at(pose, axes));
    ASSERT_TRUE(fused) << text(fused.error());
    const auto run = fuse(*fused, std::nullopt, {});
    ASSERT_TRUE(run) << text(run.error());
    ASSERT_TRUE(run->summary.rest && run->summary.rest->heading_expanded_deg);
    const double mean_s = run->summary.rest->end_s - run->summary.rest->start_s;
    const double u = *run->summary.rest->heading_expanded_deg / 1.959964;
    const double drawn = drawn_std_deg(pose, axes, mean_s, draws);
    EXPECT_NEAR(u / drawn, 1, 0.1) << "latitude " << pose.latitude << ", azimuth " << pose.azimuth;
    ++compared;
  }
  EXPECT_EQ(compared, kPoses);
}

TEST(Heading, HasUncertaintyOfMonteCarloForTetrad) {
  expect_simulated_uncertainty({fusion::axis("a", 1, 1, 1, 1), fusion::axis("b", 1, -1, -1, 1),
                                fusion::axis("c", -1, 1, -1, 1), fusion::axis("d", -1, -1, 1, 1)},
                               1);
}

TEST(Heading, HasUncertaintyOfMonteCarloForTriad) { expect_simulated_uncertainty(fusion::triad_axes(1), 2); }

/// Regression test at the latitude of Shanghai. The code once divided by the slope of an axis whose Earth rate hardly
/// depends on the tilt. For the shipped tetrad at an azimuth of 14°, that axis got a tilt of 0.3° and the heading a U
/// of 543′.
TEST(Heading, HasBoundedUncertaintyForVanishingSlope) {
  for (const double azimuth : {12.0, 14.0, 60.0}) {
    const auto fused = compensate_axes(axes_at({.latitude = 31.2, .azimuth = azimuth}, fusion::triad_axes(1)));
    ASSERT_TRUE(fused && fused->attitude);
    const auto run = fuse(*fused, std::nullopt, {});
    ASSERT_TRUE(run && run->summary.rest && run->summary.rest->heading_expanded_deg);
    EXPECT_LT(*run->summary.rest->heading_expanded_deg, 0.1);
  }
}

TEST(FixtureAngles, HaveSlopesOfEarthRate) {
  const Pose pose{.latitude = 31.2, .azimuth = 12, .elevation = 20, .roll = -35};
  constexpr double kStep_deg = 1e-4;
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.6, 0, -0.8)}) {
    Pose raised = pose, rolled = pose;
    raised.elevation += kStep_deg;
    rolled.roll += kStep_deg;
    const auto slope = [&](const Pose& other) { return (earth_in(other) - earth_in(pose)).dot(direction) / kStep_deg; };
    const FixtureSlopes slopes = fixture_slopes(recorded_angles(pose, direction));
    EXPECT_NEAR(slopes.elevation, slope(raised), 1e-5);
    EXPECT_NEAR(slopes.roll, slope(rolled), 1e-5);
    EXPECT_NEAR(slopes.direction, kDegree * earth_in(pose).cross(direction).norm() / std::sqrt(2), 1e-9);
  }
}

TEST(FixtureAngles, AreAssumedIndividuallyWhenMissing) {
  const Pose pose{.latitude = 45, .azimuth = 30};
  data::Dataset dataset;
  dataset.gyro_uncertainty = recorded_angles(pose, {0, 0.6, 0.8});
  dataset.earth_rate_deg_per_h = earth_in(pose).dot(Eigen::Vector3d(0, 0.6, 0.8));
  const auto row = [&](Source source) {
    const auto rows = budget_of_earth_rate(dataset);
    return *std::ranges::find(rows, source, &BudgetRow::source);
  };
  const double known = contribution_deg_per_h(row(Source::fixture_elevation));
  EXPECT_FALSE(row(Source::fixture_elevation).assumed);
  dataset.gyro_uncertainty.elevation_uncertainty_deg.reset();
  EXPECT_TRUE(row(Source::fixture_elevation).assumed);
  EXPECT_DOUBLE_EQ(row(Source::fixture_elevation).standard_uncertainty, 1.0 / 60) << "1′";
  EXPECT_GT(contribution_deg_per_h(row(Source::fixture_elevation)), known)
      << "the assumed uncertainty is larger than the recorded one";
  EXPECT_FALSE(row(Source::fixture_roll).assumed);
  EXPECT_EQ(row(Source::fixture_roll).standard_uncertainty, kUncertainty.roll);
  dataset.gyro_uncertainty.roll_uncertainty_deg.reset();
  dataset.gyro_uncertainty.direction_uncertainty_deg.reset();
  for (const Source source : {Source::fixture_roll, Source::axis_direction}) EXPECT_TRUE(row(source).assumed);
}

}  // namespace
}  // namespace gyrotherm::model
