#include "analysis/data/noise_floor.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>

namespace gyrotherm {
namespace {

/// Clusters of white noise on a slow drift, one long hold and one ramp.
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

TEST(NoiseFloor, IsTheWhiteNoiseUnderADrift) {
  const Clusters clusters = noisy_clusters(4000, 0.002);
  Clusters last_hour = clusters;
  const NoiseFloor floor = noise_floor(last_hour, {});
  EXPECT_EQ(floor.differences, 35) << "36 clusters in the last hour";
  EXPECT_NEAR(floor.deg_per_h, 0.002, 0.0008);
}

TEST(NoiseFloor, LooksOnlyInsideHolds) {
  Clusters clusters = noisy_clusters(100, 0.002);
  clusters.segment.tail(50).setOnes();
  clusters.last_segment.tail(51).setOnes();  // the corner lies inside cluster 49
  const RunInfo::SegmentInfo hold{"hold", true, {}, {}, -1}, ramp{"ramp", false, {}, {}, -1};
  EXPECT_EQ(noise_floor(clusters, {hold, ramp}).differences, 35);
  EXPECT_EQ(noise_floor(clusters, {ramp, hold}).differences, 35);
  EXPECT_EQ(noise_floor(clusters, {hold, hold}).differences, 70);
  EXPECT_TRUE(std::isnan(noise_floor(clusters, {ramp, ramp}).deg_per_h));
}

TEST(NoiseFloor, LeavesOutDifferencesAcrossAGap) {
  Clusters clusters = noisy_clusters(30, 0.002);
  clusters.start_s.tail(10).array() += 300;
  EXPECT_EQ(noise_floor(clusters, {}).differences, 28);
}

TEST(NoiseFloor, HasAnErrorBarThatHoldsTheTruth) {
  int held = 0;
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Clusters clusters = noisy_clusters(360, 0.002, seed);
    std::vector<RunInfo::SegmentInfo> segments(10, {"hold", true, {}, {}, -1});
    for (Eigen::Index k = 0; k < 360; ++k) clusters.segment(k) = clusters.last_segment(k) = static_cast<int>(k / 36);
    const NoiseFloor floor = noise_floor(clusters, segments);
    EXPECT_EQ(floor.differences, 350);
    held += std::abs(floor.deg_per_h - 0.002) < 2 * floor.error_deg_per_h ? 1 : 0;
  }
  EXPECT_GE(held, 182) << "of 200, at 95 %";
  EXPECT_LE(held, 199) << "of 200, at 95 %: the error bars are too long";
}

TEST(OverFit, ExpectsTheFloorLessWhatParametersExplain) {
  const NoiseFloor floor{.deg_per_h = 0.002, .differences = 800, .error_deg_per_h = 0.00006};
  EXPECT_DOUBLE_EQ(expected_in_sample_std(floor, 500, 2000), 0.002 * std::sqrt(0.75));
  EXPECT_TRUE(std::isnan(expected_in_sample_std(floor, 0, 2000)));
  EXPECT_TRUE(std::isnan(expected_in_sample_std(floor, 2000, 2000)));
  EXPECT_TRUE(std::isnan(expected_in_sample_std(floor, std::nan(""), 2000)));
}

/// Least squares of p parameters on white noise leaves floor·√(1 − p/n).
TEST(OverFit, TheExpectationIsWhatLeastSquaresLeaves) {
  constexpr Eigen::Index kRows = 400, kParameters = 100;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(random); };
    const Eigen::MatrixXd design = Eigen::MatrixXd::NullaryExpr(kRows, kParameters, draw);
    const Eigen::VectorXd noise = Eigen::VectorXd::NullaryExpr(kRows, draw);
    const Eigen::VectorXd left = noise - design * design.colPivHouseholderQr().solve(noise);
    const NoiseFloor floor{.deg_per_h = 1, .differences = 100, .error_deg_per_h = 0.1};
    const double expected = expected_in_sample_std(floor, kParameters, kRows);
    EXPECT_NEAR(figures_of(left).std, expected, 4 * expected / std::sqrt(2.0 * (kRows - kParameters))) << seed;
  }
}

TEST(OverFit, WarnsOnlyBeyondTheErrorBar) {
  const NoiseFloor floor{.deg_per_h = 0.002, .differences = 800, .error_deg_per_h = 0.00006};
  Figures residual{.std = 0.0019, .count = 2000, .effective = {2000, 2000}};
  EXPECT_FALSE(over_fit_warning(residual, floor, 0)) << "0.0001 below, the bar is 0.00013";
  residual.std = 0.0018;
  const auto warning = over_fit_warning(residual, floor, 0);
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("over-fit"), std::string::npos);
  EXPECT_EQ(warning->find("parameters"), std::string::npos);
  EXPECT_NE(over_fit_warning(residual, floor, 300)->find("300 effective parameters on 2000 clusters"),
            std::string::npos);
  residual.effective = {50, 50};
  EXPECT_FALSE(over_fit_warning(residual, floor, 0)) << "50 independent values say little";
}

TEST(OverFit, IsNotSaidWhereThereIsNoFloor) {
  const NoiseFloor none{.deg_per_h = std::nan(""), .differences = 0, .error_deg_per_h = std::nan("")};
  EXPECT_FALSE(over_fit_warning({.std = 0, .count = 10}, none, 3));
}

}  // namespace
}  // namespace gyrotherm
