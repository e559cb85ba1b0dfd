#include "analysis/data/hold_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/analysis/data/simulated_noise.hpp"

namespace gyrotherm {
namespace {

/// Holds of two hours with ramps of half an hour between them: white noise in the last hour of each hold, a great slope
/// everywhere else.
Dataset quiet_hours(int holds, double N, std::uint64_t seed) {
  constexpr Eigen::Index kHold = 7200, kRamp = 1800, kQuiet = 3600;
  std::mt19937_64 random(seed);
  const Eigen::Index rows = holds * (kHold + kRamp);
  Dataset dataset;
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  dataset.bias_deg_per_h = dataset.time_s;
  dataset.segment.resize(rows);
  for (int h = 0; h < holds; ++h) {
    const Eigen::Index first = h * (kHold + kRamp);
    dataset.segments.push_back({"hold", true, {}, {}, -1});
    dataset.segments.push_back({"ramp", false, {}, {}, -1});
    dataset.segment.segment(first, kHold).setConstant(2 * h);
    dataset.segment.segment(first + kHold, kRamp).setConstant(2 * h + 1);
    dataset.bias_deg_per_h.segment(first + kHold - kQuiet, kQuiet) = simulate({.N = N}, kQuiet, 1, random).array() + h;
  }
  return dataset;
}

TEST(HoldNoise, IsOfTheLastHourOfEachHoldAlone) {
  const HoldNoise noise = noise_of_holds(quiet_hours(5, 3e-4, 1));
  EXPECT_EQ(noise.holds, 5);
  EXPECT_EQ(noise.stretches, 5);
  EXPECT_EQ(noise.seconds, 5 * 3600);
  const NoiseCoefficient& n = of(noise.fit, NoiseTerm::angle_random_walk);
  EXPECT_NEAR(n.value, 3e-4, 4 * n.error);
  EXPECT_NE(noise.statement.find("5 holds"), std::string::npos) << noise.statement;
}

TEST(HoldNoise, MissingSamplesEndAStretch) {
  Dataset dataset = quiet_hours(2, 3e-4, 2);
  dataset.bias_deg_per_h(6000) = std::numeric_limits<double>::quiet_NaN();
  dataset.time_s.tail(dataset.time_s.size() - 14000).array() += 30;
  const HoldNoise noise = noise_of_holds(dataset);
  EXPECT_EQ(noise.holds, 2);
  EXPECT_EQ(noise.stretches, 4);
  EXPECT_EQ(noise.seconds, 2 * 3600 - 1 - 30) << "the hour of the second hold ends as late as before";
  const NoiseCoefficient& n = of(noise.fit, NoiseTerm::angle_random_walk);
  EXPECT_NEAR(n.value, 3e-4, 4 * n.error);
}

TEST(HoldNoise, OfNoHoldIsNothing) {
  Dataset dataset = quiet_hours(1, 3e-4, 3);
  for (auto& segment : dataset.segments) segment.hold = false;
  const HoldNoise noise = noise_of_holds(dataset);
  EXPECT_TRUE(noise.curve.empty());
  EXPECT_EQ(noise.holds, 0);
  for (const NoiseCoefficient& coefficient : noise.fit.coefficients) {
    EXPECT_FALSE(coefficient.seen);
    EXPECT_TRUE(std::isnan(coefficient.at_most));
  }
  EXPECT_TRUE(noise_of_holds(Dataset{}).curve.empty());
}

TEST(HoldNoise, ARecordWithoutSegmentsIsOneHold) {
  std::mt19937_64 random(4);
  Dataset dataset;
  dataset.imported = true;
  dataset.time_s = Eigen::VectorXd::LinSpaced(72000, 0, 7199.9);
  dataset.bias_deg_per_h = simulate({.N = 0.01}, 72000, 0.1, random);
  dataset.segment.setConstant(72000, -1);
  const HoldNoise noise = noise_of_holds(dataset);
  EXPECT_NEAR(noise.interval_s, 0.1, 1e-9);
  EXPECT_NEAR(noise.seconds, 3600, 0.2);
  const NoiseCoefficient& n = of(noise.fit, NoiseTerm::angle_random_walk);
  EXPECT_NEAR(n.value, 0.01, 4 * n.error);
}

/// The great slope that a model takes away leaves the noise.
TEST(HoldNoise, OfCompensatedHoldsIsWithoutWhatTheModelTakesAway) {
  Dataset dataset = quiet_hours(3, 3e-4, 5);
  const Eigen::VectorXd slope = 1e-5 * dataset.time_s;
  const Dataset quiet = dataset;
  dataset.bias_deg_per_h += slope;
  Clusters clusters;
  const Eigen::Index count = dataset.time_s.size() / 100;
  clusters.start_s = Eigen::VectorXd::LinSpaced(count, 0, 100.0 * static_cast<double>(count - 1));
  clusters.bias_deg_per_h = dataset.bias_deg_per_h.reshaped(100, count).colwise().mean().transpose();
  const Eigen::VectorXd residual = quiet.bias_deg_per_h.reshaped(100, count).colwise().mean().transpose();
  const HoldNoise found = noise_of_compensated_holds(dataset, clusters, residual);
  const HoldNoise expected = noise_of_holds(quiet);
  ASSERT_EQ(found.curve.size(), expected.curve.size());
  for (std::size_t k = 0; k < found.curve.size(); ++k) {
    EXPECT_NEAR(found.curve[k].deviation_deg_per_h, expected.curve[k].deviation_deg_per_h,
                1e-3 * expected.curve[k].deviation_deg_per_h);
  }
  EXPECT_NE(found.statement.find("compensated"), std::string::npos);
  EXPECT_GT(noise_of_holds(dataset).curve.back().deviation_deg_per_h, 3 * expected.curve.back().deviation_deg_per_h);
}

TEST(HoldNoise, OfCompensatedHoldsMissesSamplesBesideAMissingCluster) {
  Dataset dataset = quiet_hours(1, 3e-4, 6);
  Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(90, 0, 8900);
  clusters.start_s.tail(20).array() += 100;  // one cluster of the hold is not there
  clusters.bias_deg_per_h.setZero(90);
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(90);
  residual(40) = std::numeric_limits<double>::quiet_NaN();
  const HoldNoise noise = noise_of_compensated_holds(dataset, clusters, residual);
  EXPECT_EQ(noise.stretches, 3);
  EXPECT_EQ(noise.seconds, 3600 - 200 - 1 - 199);
}

TEST(AllanCurveOfClusters, BreaksWhereAClusterOrAValueIsMissing) {
  Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(60, 0, 5900);
  clusters.start_s.tail(30).array() += 500;
  Eigen::VectorXd values = Eigen::VectorXd::Zero(60);
  values.tail(30).setConstant(1000);
  values(10) = std::numeric_limits<double>::quiet_NaN();
  const AllanCurve curve = allan_curve_of(values, clusters);
  ASSERT_FALSE(curve.empty());
  EXPECT_EQ(curve.front().tau_s, 100);
  EXPECT_EQ(curve.front().differences, 9 + 18 + 29);
  for (const AllanPoint& point : curve) EXPECT_EQ(point.deviation_deg_per_h, 0);
}

}  // namespace
}  // namespace gyrotherm
