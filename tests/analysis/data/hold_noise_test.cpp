// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/hold_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

/// Returns clusters of white noise on a slow drift, for one long hold and one ramp.
Clusters noisy_clusters(Eigen::Index count, double noise, std::uint64_t seed = 5) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(count, 0, 100.0 * static_cast<double>(count - 1));
  clusters.bias_deg_per_h = Eigen::VectorXd::NullaryExpr(count, [&] { return noise * normal(random); });
  clusters.bias_deg_per_h += 1e-7 * clusters.start_s;
  clusters.segment.setZero(count);
  clusters.last_segment.setZero(count);
  return clusters;
}

const record::RunInfo::SegmentInfo kHoldSegment{"hold", true, {}, {}, -1}, kRampSegment{"ramp", false, {}, {}, -1};

TEST(NoiseFloor, MeasuresWhiteNoiseUnderDrift) {
  const NoiseFloor floor = noise_floor(noisy_clusters(4000, 0.002), {kHoldSegment});
  EXPECT_EQ(floor.differences, 34) << "second differences of 36 clusters in the last hour";
  EXPECT_NEAR(floor.deg_per_h, 0.002, 0.0008);
  EXPECT_EQ(floor.statement, "Hadamard deviation at τ = 100 s of the raw bias in the last hour of 1 hold");
}

TEST(NoiseFloor, IgnoresSteadyDrift) {
  Clusters clusters = noisy_clusters(100, 0.002);
  const NoiseFloor floor = noise_floor(clusters, {kHoldSegment});
  // Adds a drift of five noise floors per mean.
  clusters.bias_deg_per_h += 1e-4 * clusters.start_s;
  EXPECT_NEAR(noise_floor(clusters, {kHoldSegment}).deg_per_h, floor.deg_per_h, 1e-12);
}

/// Holds of ten minutes, as in a random program. The bias still decays by 7 % between successive means.
TEST(NoiseFloor, IsUnbiasedOnShortDriftingHolds) {
  constexpr int kHolds = 400, kMeans = 6;
  Clusters clusters = noisy_clusters(kHolds * kMeans, 0.002);
  double first_differences = 0;
  for (Eigen::Index k = 0; k < kHolds * kMeans; ++k) {
    clusters.segment(k) = clusters.last_segment(k) = static_cast<int>(k / kMeans);
    clusters.bias_deg_per_h(k) += 0.02 * std::exp(-0.07 * static_cast<double>(k % kMeans));
    if (k % kMeans > 0)
      first_differences += std::pow(clusters.bias_deg_per_h(k) - clusters.bias_deg_per_h(k - 1), 2) / 2;
  }
  const NoiseFloor floor =
      noise_floor(clusters, std::vector<record::RunInfo::SegmentInfo>(static_cast<std::size_t>(kHolds), kHoldSegment));
  EXPECT_EQ(floor.differences, kHolds * (kMeans - 2));
  EXPECT_NEAR(floor.deg_per_h, 0.002, 3 * floor.error_deg_per_h);
  EXPECT_GT(std::sqrt(first_differences / (kHolds * (kMeans - 1))), 1.05 * 0.002) << "first differences are biased";
}

/// The residual wanders by ten times its white noise, has steps at the borders of folds, and spikes.
TEST(ResidualNoise, MeasuresWhiteNoiseWithoutHolds) {
  constexpr int kSeeds = 100;
  double squares = 0, errors = 0, deviations = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Clusters clusters = noisy_clusters(400, 0.002, seed);
    Eigen::VectorXd residual = clusters.bias_deg_per_h;
    for (Eigen::Index k = 0; k < 400; ++k)
      residual(k) += 0.02 * std::sin(0.05 * static_cast<double>(k)) + (k >= 100 && k < 200 ? 0.05 : 0);
    residual(50) += 1;
    residual(300) = std::numeric_limits<double>::quiet_NaN();
    const NoiseFloor noise = residual_noise(clusters, residual);
    squares += std::pow(noise.deg_per_h, 2) / kSeeds;
    errors += std::pow(noise.error_deg_per_h, 2) / kSeeds;
    deviations += std::pow(noise.deg_per_h - 0.002, 2) / kSeeds;
    EXPECT_GE(noise.differences, 380);
    EXPECT_LE(noise.differences, 398 - 3 - 3);
    EXPECT_NE(noise.statement.find("the record has no hold"), std::string::npos);
  }
  EXPECT_NEAR(std::sqrt(squares), 0.002, 0.00004);
  EXPECT_NEAR(std::sqrt(errors / deviations), 1, 0.25) << "the standard error is the scatter between seeds";
}

TEST(ResidualNoise, NeedsThreeNeighbours) {
  Clusters clusters = noisy_clusters(6, 0.002);
  Eigen::VectorXd residual = clusters.bias_deg_per_h;
  residual(2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(residual_noise(clusters, residual).differences, 1);
  clusters.start_s(5) += 1000;
  EXPECT_EQ(residual_noise(clusters, residual).differences, 0);
  EXPECT_TRUE(std::isnan(residual_noise(clusters, residual).deg_per_h));
  EXPECT_EQ(residual_noise(noisy_clusters(2, 0.002), Eigen::Vector2d::Zero()).differences, 0);
  EXPECT_EQ(residual_noise(noisy_clusters(9, 0), Eigen::VectorXd::Zero(9)).deg_per_h, 0) << "a frozen residual";
}

/// For a pulse of 1″, more than half of the noise of a mean is quantisation, which is correlated between adjacent
/// means.
TEST(NoiseFloor, CorrectsForQuantisationOfPulses) {
  constexpr Eigen::Index kMeans = 34;
  constexpr double kPulse_arcsec = 1, kLength_s = 100;
  for (const double white_deg_per_h : {0.0, 0.002, 0.02}) {
    double floors = 0, noise = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal(0, white_deg_per_h);
      std::uniform_real_distribution<double> anywhere(5, 15);
      Clusters clusters = noisy_clusters(kMeans, 0);
      const double rate_deg_per_h = anywhere(random);  // °/h equals ″/s
      double angle = anywhere(random), counted = std::floor(angle / kPulse_arcsec);
      for (double& bias : clusters.bias_deg_per_h) {
        angle += (rate_deg_per_h + normal(random)) * kLength_s;
        const double now = std::floor(angle / kPulse_arcsec);
        bias = (now - counted) * kPulse_arcsec / kLength_s - rate_deg_per_h;
        counted = now;
      }
      floors += std::pow(noise_floor(clusters, {kHoldSegment}, kPulse_arcsec).deg_per_h, 2);
      noise += clusters.bias_deg_per_h.squaredNorm() / kMeans;
    }
    EXPECT_NEAR(std::sqrt(floors / noise), 1, 0.1)
        << white_deg_per_h << ": without correction the ratio is 1.29 for quantisation only";
  }
}

/// An imported ramp of 2000 s that is an exact straight line must not cause an over-fit warning.
TEST(NoiseFloor, IsMissingWithoutHolds) {
  Clusters ramp = noisy_clusters(20, 0.002);
  ramp.segment.setConstant(-1);
  ramp.last_segment.setConstant(-1);
  ramp.bias_deg_per_h += 5e-4 * ramp.start_s;
  for (const auto& segments : {std::vector<record::RunInfo::SegmentInfo>{}, {kRampSegment}}) {
    const NoiseFloor floor = noise_floor(ramp, segments);
    EXPECT_TRUE(std::isnan(floor.deg_per_h));
    EXPECT_TRUE(std::isnan(floor.error_deg_per_h));
    EXPECT_EQ(floor.differences, 0);
    EXPECT_EQ(floor.statement, "the record has no hold");
    EXPECT_FALSE(over_fit_warning({.std = 1e-9, .count = 20, .effective = {20, 20}}, floor, 2));
  }
}

TEST(NoiseFloor, GivesReasonWhenHoldsAreTooShort) {
  Clusters clusters = noisy_clusters(2, 0.002);
  const NoiseFloor floor = noise_floor(clusters, {kHoldSegment});
  EXPECT_TRUE(std::isnan(floor.deg_per_h));
  EXPECT_EQ(floor.statement, "no hold has three neighbouring means in its last hour");
}

TEST(NoiseFloor, UsesOnlyHolds) {
  Clusters clusters = noisy_clusters(100, 0.002);
  clusters.segment.tail(50).setOnes();
  // The segment ends inside cluster 49.
  clusters.last_segment.tail(51).setOnes();
  EXPECT_EQ(noise_floor(clusters, {kHoldSegment, kRampSegment}).differences, 34);
  EXPECT_EQ(noise_floor(clusters, {kRampSegment, kHoldSegment}).differences, 34);
  EXPECT_EQ(noise_floor(clusters, {kHoldSegment, kHoldSegment}).differences, 68);
  EXPECT_TRUE(std::isnan(noise_floor(clusters, {kRampSegment, kRampSegment}).deg_per_h));
}

TEST(NoiseFloor, SkipsDifferencesAcrossGap) {
  Clusters clusters = noisy_clusters(30, 0.002);
  clusters.start_s.tail(10).array() += 300;
  EXPECT_EQ(noise_floor(clusters, {kHoldSegment}).differences, 26);
}

TEST(NoiseFloor, HasErrorBarThatCoversTruth) {
  int held = 0;
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Clusters clusters = noisy_clusters(360, 0.002, seed);
    std::vector<record::RunInfo::SegmentInfo> segments(10, kHoldSegment);
    for (Eigen::Index k = 0; k < 360; ++k) clusters.segment(k) = clusters.last_segment(k) = static_cast<int>(k / 36);
    const NoiseFloor floor = noise_floor(clusters, segments);
    EXPECT_EQ(floor.differences, 340);
    held += std::abs(floor.deg_per_h - 0.002) < 2 * floor.error_deg_per_h ? 1 : 0;
  }
  EXPECT_GE(held, 182) << "of 200 intervals at 95 %";
  EXPECT_LE(held, 199) << "of 200 intervals at 95 %; the error bars are too wide";
}

TEST(OverFit, ExpectsFloorReducedByParameters) {
  const NoiseFloor floor{.deg_per_h = 0.002, .differences = 800, .error_deg_per_h = 0.00006};
  EXPECT_DOUBLE_EQ(expected_in_sample_std(floor, 500, 2000), 0.002 * std::sqrt(0.75));
  EXPECT_TRUE(std::isnan(expected_in_sample_std(floor, 0, 2000)));
  EXPECT_TRUE(std::isnan(expected_in_sample_std(floor, 2000, 2000)));
  EXPECT_TRUE(std::isnan(expected_in_sample_std(floor, std::nan(""), 2000)));
}

/// A least-squares fit of p parameters to white noise has a residual of floor·√(1 − p/n).
TEST(OverFit, ExpectsResidualOfLeastSquares) {
  constexpr Eigen::Index kRows = 400, kParameters = 100;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(random); };
    const Eigen::MatrixXd design = Eigen::MatrixXd::NullaryExpr(kRows, kParameters, draw);
    const Eigen::VectorXd noise = Eigen::VectorXd::NullaryExpr(kRows, draw);
    const Eigen::VectorXd residual = noise - design * design.colPivHouseholderQr().solve(noise);
    const NoiseFloor floor{.deg_per_h = 1, .differences = 100, .error_deg_per_h = 0.1};
    const double expected = expected_in_sample_std(floor, kParameters, kRows);
    EXPECT_NEAR(compute_figures(residual).std, expected, 4 * expected / std::sqrt(2.0 * (kRows - kParameters))) << seed;
  }
}

TEST(OverFit, WarnsOnlyOutsideErrorBar) {
  const NoiseFloor floor{.deg_per_h = 0.002, .differences = 800, .error_deg_per_h = 0.00006};
  Figures residual{.std = 0.0019, .count = 2000, .effective = {2000, 2000}};
  EXPECT_FALSE(over_fit_warning(residual, floor, 0)) << "the difference of 0.0001 is within the error bar of 0.00013";
  residual.std = 0.0018;
  const auto warning = over_fit_warning(residual, floor, 0);
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("over-fit"), std::string::npos);
  EXPECT_EQ(warning->find("parameters"), std::string::npos);
  EXPECT_NE(over_fit_warning(residual, floor, 300)->find("300 effective parameters on 2000 clusters"),
            std::string::npos);
  residual.effective = {50, 50};
  EXPECT_FALSE(over_fit_warning(residual, floor, 0)) << "the error bar of 50 independent values is wide";
}

TEST(OverFit, GivesNoWarningWithoutFloor) {
  const NoiseFloor none{.deg_per_h = std::nan(""), .differences = 0, .error_deg_per_h = std::nan("")};
  EXPECT_FALSE(over_fit_warning({.std = 0, .count = 10}, none, 3));
}

/// Returns holds of two hours with ramps of half an hour between them. The last hour of each hold has white noise; the
/// bias has a steep slope elsewhere.
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

TEST(HoldNoise, UsesOnlyLastHourOfEachHold) {
  const HoldNoise noise = measure_hold_noise(quiet_hours(5, 3e-4, 1));
  EXPECT_EQ(noise.holds, 5);
  EXPECT_EQ(noise.stretches, 5);
  EXPECT_EQ(noise.seconds, 5 * 3600);
  const NoiseCoefficient& n = find_coefficient(noise.fit, NoiseTerm::angle_random_walk);
  EXPECT_NEAR(n.value, 3e-4, 4 * n.error);
  EXPECT_NE(noise.statement.find("5 holds"), std::string::npos) << noise.statement;
}

TEST(HoldNoise, EndsStretchAtMissingSamples) {
  Dataset dataset = quiet_hours(2, 3e-4, 2);
  dataset.bias_deg_per_h(6000) = std::numeric_limits<double>::quiet_NaN();
  dataset.time_s.tail(dataset.time_s.size() - 14000).array() += 30;
  const HoldNoise noise = measure_hold_noise(dataset);
  EXPECT_EQ(noise.holds, 2);
  EXPECT_EQ(noise.stretches, 4);
  EXPECT_EQ(noise.seconds, 2 * 3600 - 1 - 30) << "the last hour of the second hold is unchanged";
  const NoiseCoefficient& n = find_coefficient(noise.fit, NoiseTerm::angle_random_walk);
  EXPECT_NEAR(n.value, 3e-4, 4 * n.error);
}

TEST(HoldNoise, UsesOnlySelectedClusters) {
  const Dataset dataset = quiet_hours(2, 3e-4, 2);
  Clusters clusters;
  // Selects the first hold and its ramp.
  clusters.start_s = Eigen::VectorXd::LinSpaced(90, 0, 8900);
  const HoldNoise noise = measure_hold_noise(dataset, clusters);
  EXPECT_EQ(noise.holds, 1);
  EXPECT_EQ(noise.seconds, 3600);
  // Selects 1000 s of its last hour.
  clusters.start_s = clusters.start_s.segment(40, 10).eval();
  EXPECT_EQ(measure_hold_noise(dataset, clusters).seconds, 1000);
  clusters.start_s.resize(0);
  EXPECT_TRUE(measure_hold_noise(dataset, clusters).curve.empty());
}

TEST(HoldNoise, IsEmptyWithoutHold) {
  Dataset dataset = quiet_hours(1, 3e-4, 3);
  for (auto& segment : dataset.segments) segment.hold = false;
  const HoldNoise noise = measure_hold_noise(dataset);
  EXPECT_TRUE(noise.curve.empty());
  EXPECT_EQ(noise.holds, 0);
  for (const NoiseCoefficient& coefficient : noise.fit.coefficients) {
    EXPECT_FALSE(coefficient.seen);
    EXPECT_TRUE(std::isnan(coefficient.at_most));
  }
  EXPECT_EQ(measure_hold_noise(dataset).statement, "the record has no hold");
  EXPECT_TRUE(measure_hold_noise(Dataset{}).curve.empty());
}

TEST(HoldNoise, HasPointAtClusterLength) {
  const Dataset dataset = quiet_hours(5, 3e-4, 1);
  const HoldNoise noise = measure_hold_noise(dataset);
  const auto point = std::ranges::find(noise.curve, 100, &AllanPoint::tau_s);
  ASSERT_NE(point, noise.curve.end());
  EXPECT_NEAR(point->deviation_deg_per_h, 3e-4 * 6, 4 * point->error_deg_per_h) << "N/√τ";
  EXPECT_TRUE(std::ranges::is_sorted(noise.curve, {}, &AllanPoint::tau_s));
  EXPECT_EQ(std::ranges::count(noise.curve, 100, &AllanPoint::tau_s), 1);
}

TEST(HoldNoise, IsEmptyForImportedRecordWithoutHolds) {
  Dataset dataset = quiet_hours(1, 3e-4, 3);
  dataset.imported = true;
  dataset.segments.clear();
  dataset.segment.setConstant(-1);
  EXPECT_TRUE(measure_hold_noise(dataset).curve.empty());
  EXPECT_EQ(measure_hold_noise(dataset).statement, "the record has no hold");
}

TEST(HoldNoise, UsesSampleIntervalOfRecord) {
  std::mt19937_64 random(4);
  Dataset dataset;
  dataset.imported = true;
  dataset.time_s = Eigen::VectorXd::LinSpaced(72000, 0, 7199.9);
  dataset.bias_deg_per_h = simulate({.N = 0.01}, 72000, 0.1, random);
  dataset.segments = {kHoldSegment};
  dataset.segment.setZero(72000);
  const HoldNoise noise = measure_hold_noise(dataset);
  EXPECT_NEAR(noise.interval_s, 0.1, 1e-9);
  EXPECT_NEAR(noise.seconds, 3600, 0.2);
  const NoiseCoefficient& n = find_coefficient(noise.fit, NoiseTerm::angle_random_walk);
  EXPECT_NEAR(n.value, 0.01, 4 * n.error);
}

/// After compensation of the steep slope, only the noise must remain.
TEST(HoldNoise, ExcludesCompensatedPart) {
  Dataset dataset = quiet_hours(3, 3e-4, 5);
  const Eigen::VectorXd slope = 1e-5 * dataset.time_s;
  const Dataset quiet = dataset;
  dataset.bias_deg_per_h += slope;
  Clusters clusters;
  const Eigen::Index count = dataset.time_s.size() / 100;
  clusters.start_s = Eigen::VectorXd::LinSpaced(count, 0, 100.0 * static_cast<double>(count - 1));
  clusters.bias_deg_per_h = dataset.bias_deg_per_h.reshaped(100, count).colwise().mean().transpose();
  const Eigen::VectorXd residual = quiet.bias_deg_per_h.reshaped(100, count).colwise().mean().transpose();
  const HoldNoise found = measure_compensated_hold_noise(dataset, clusters, residual);
  const HoldNoise expected = measure_hold_noise(quiet);
  ASSERT_EQ(found.curve.size(), expected.curve.size());
  for (std::size_t k = 0; k < found.curve.size(); ++k) {
    EXPECT_NEAR(found.curve[k].deviation_deg_per_h, expected.curve[k].deviation_deg_per_h,
                1e-3 * expected.curve[k].deviation_deg_per_h);
  }
  EXPECT_NE(found.statement.find("compensated"), std::string::npos);
  EXPECT_GT(measure_hold_noise(dataset).curve.back().deviation_deg_per_h,
            3 * expected.curve.back().deviation_deg_per_h);
}

TEST(HoldNoise, OmitsSamplesNextToMissingCluster) {
  Dataset dataset = quiet_hours(1, 3e-4, 6);
  Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(90, 0, 8900);
  // Removes one cluster of the hold.
  clusters.start_s.tail(20).array() += 100;
  clusters.bias_deg_per_h.setZero(90);
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(90);
  residual(40) = std::numeric_limits<double>::quiet_NaN();
  const HoldNoise noise = measure_compensated_hold_noise(dataset, clusters, residual);
  EXPECT_EQ(noise.stretches, 3);
  EXPECT_EQ(noise.seconds, 3600 - 200 - 1 - 199);
}

TEST(AllanCurveOfClusters, EndsStretchAtMissingClusterOrValue) {
  Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(60, 0, 5900);
  clusters.start_s.tail(30).array() += 500;
  Eigen::VectorXd values = Eigen::VectorXd::Zero(60);
  values.tail(30).setConstant(1000);
  values(10) = std::numeric_limits<double>::quiet_NaN();
  const AllanCurve curve = cluster_allan_curve(values, clusters);
  ASSERT_FALSE(curve.empty());
  EXPECT_EQ(curve.front().tau_s, 100);
  EXPECT_EQ(curve.front().differences, 9 + 18 + 29);
  for (const AllanPoint& point : curve) EXPECT_EQ(point.deviation_deg_per_h, 0);
}

}  // namespace

}  // namespace gyrotherm::data
