#include "analysis/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "synthetic_run.hpp"

namespace gyrotherm {
namespace {

TEST(Figures, AreEquation11AndWhatItHides) {
  const Figures figures = figures_of(Eigen::Vector4d{1, 2, 3, -8});
  EXPECT_DOUBLE_EQ(figures.mean, -0.5);
  EXPECT_DOUBLE_EQ(figures.std, std::sqrt(77.0 / 3));
  EXPECT_DOUBLE_EQ(figures.rmse, std::sqrt(78.0 / 4));
  EXPECT_DOUBLE_EQ(figures.max_abs, 8);
  EXPECT_EQ(figures.count, 4);
  EXPECT_EQ(figures_of(Eigen::VectorXd{}).count, 0);
}

TEST(Improvement, OfThePapersTablesIsBothOfItsKinds) {
  const Improvement rate = improvement(0.0258, 0.0089, 0.0021);
  EXPECT_NEAR(rate.three_point_from_original, 0.65504, 5e-6);
  EXPECT_NEAR(rate.multi_point_from_original, 0.91860, 5e-6);
  EXPECT_NEAR(rate.paper_ratio, 0.40237, 5e-6);
  EXPECT_NEAR(rate.residual_reduction, 0.76404, 5e-6);
  const Improvement random = improvement(0.0283, 0.0091, 0.0023);
  EXPECT_NEAR(random.three_point_from_original, 0.67845, 5e-6);
  EXPECT_NEAR(random.multi_point_from_original, 0.91873, 5e-6);
  EXPECT_NEAR(random.paper_ratio, 0.35417, 5e-6);
  EXPECT_NEAR(random.residual_reduction, 0.74725, 5e-6);
}

TEST(Improvement, IsThePrintedOneOnlyFromRoundedPercentages) {
  const auto rounded = [](double fraction) { return std::round(1000 * fraction) / 10; };
  const Improvement rate = improvement(0.0258, 0.0089, 0.0021);
  const double three = rounded(rate.three_point_from_original), multi = rounded(rate.multi_point_from_original);
  EXPECT_NEAR(100 * (multi - three) / three, 40.305, 5e-4);
}

TEST(AllanDeviation, IsTheNistReference) {
  Eigen::VectorXd values(1000);
  std::int64_t n = 1234567890;
  for (double& value : values) {
    value = static_cast<double>(n) / 2147483647.0;
    n = 16807 * n % 2147483647;
  }
  EXPECT_NEAR(overlapping_allan_deviation(values, 1), 2.922319e-01, 5e-8);
  EXPECT_NEAR(overlapping_allan_deviation(values, 10), 9.159953e-02, 5e-9);
  EXPECT_NEAR(overlapping_allan_deviation(values, 100), 3.241343e-02, 5e-9);
}

/// Clusters of white noise on a slow drift, one long hold and one ramp.
Clusters noisy_clusters(Eigen::Index count, double noise) {
  std::mt19937_64 random(5);
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

}  // namespace
}  // namespace gyrotherm
