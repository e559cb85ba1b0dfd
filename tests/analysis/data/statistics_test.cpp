// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/analysis/real_records.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

TEST(Figures, MatchEquation11) {
  const Figures figures = compute_figures(Eigen::Vector4d{1, 2, 3, -8});
  EXPECT_DOUBLE_EQ(figures.mean, -0.5);
  EXPECT_DOUBLE_EQ(figures.std, std::sqrt(77.0 / 3));
  EXPECT_DOUBLE_EQ(figures.rmse, std::sqrt(78.0 / 4));
  EXPECT_DOUBLE_EQ(figures.max_abs, 8);
  EXPECT_EQ(figures.count, 4);
  EXPECT_EQ(compute_figures(Eigen::VectorXd{}).count, 0);
}

TEST(Figures, ArePrintedWithDecimalsOfTheirScatter) {
  const auto print = [](double std, double mean, double rmse, double max_abs) {
    Figures figures;
    figures.std = std, figures.mean = mean, figures.rmse = rmse, figures.max_abs = max_abs;
    return format_figures(figures);
  };
  EXPECT_EQ(print(0.0022474, -7.7e-19, 0.002216, 0.005088), "std 0.002247, mean 0.000000, rmse 0.002216, max 0.005088");
  EXPECT_EQ(print(251.3, -12.34, 251.6, 1004.6), "std 251.3, mean -12.3, rmse 251.6, max 1004.6");
  EXPECT_EQ(print(12345, -0.4, 12345, 20000), "std 12345, mean 0, rmse 12345, max 20000");
  EXPECT_EQ(print(0, 0.5, 0.5, 0.5), "std 0.0000, mean 0.5000, rmse 0.5000, max 0.5000") << "one value has no scatter";
  EXPECT_EQ(print(0, 0, 0, 0), "std 0.000, mean 0.000, rmse 0.000, max 0.000");
}

TEST(Improvement, MatchesTablesOfPaper) {
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

TEST(Improvement, MatchesPrintedValueFromRoundedPercentages) {
  const auto rounded = [](double fraction) { return std::round(1000 * fraction) / 10; };
  const Improvement rate = improvement(0.0258, 0.0089, 0.0021);
  const double three = rounded(rate.three_point_from_original), multi = rounded(rate.multi_point_from_original);
  EXPECT_NEAR(100 * (multi - three) / three, 40.305, 5e-4);
}

/// Simulates x_k = φ x_{k−1} + white noise with unit STD.
Eigen::VectorXd autoregression(double phi, Eigen::Index count, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::VectorXd values(count);
  double x = normal(random);
  for (double& value : values) {
    value = x;
    x = phi * x + std::sqrt(1 - phi * phi) * normal(random);
  }
  return values;
}

Eigen::VectorXi counted(Eigen::Index count) {
  return Eigen::VectorXi::LinSpaced(count, 0, static_cast<int>(count) - 1);
}

TEST(EffectiveNumber, IsNearlyCountForIndependentValues) {
  double sum = 0;
  constexpr int kSeeds = 50;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    const EffectiveNumber effective = effective_number(autoregression(0, 500, random), counted(500));
    EXPECT_GT(effective.of_std, 450) << seed;
    EXPECT_LE(effective.of_std, 500) << seed;
    EXPECT_LE(effective.of_mean, 500) << seed;
    sum += effective.of_std;
  }
  EXPECT_GT(sum / kSeeds, 495);
}

TEST(EffectiveNumber, MatchesBartlettForAutoregression) {
  for (const double phi : {0.5, 0.9}) {
    double of_std = 0, of_mean = 0;
    constexpr int kSeeds = 40;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      std::mt19937_64 random(seed);
      const EffectiveNumber effective = effective_number(autoregression(phi, 4000, random), counted(4000));
      of_std += effective.of_std / kSeeds;
      of_mean += effective.of_mean / kSeeds;
    }
    EXPECT_NEAR(of_std, 4000 * (1 - phi * phi) / (1 + phi * phi), 0.1 * of_std) << phi;
    EXPECT_NEAR(of_mean, 4000 * (1 - phi) / (1 + phi), 0.2 * of_mean) << phi;
  }
}

TEST(EffectiveNumber, GivesErrorBarsThatCoverTruth) {
  int std_held = 0, mean_held = 0;
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    const Eigen::VectorXd values = autoregression(0.8, 1500, random);
    Figures figures = compute_figures(values);
    figures.effective = effective_number(values, counted(1500));
    std_held += std::abs(figures.std - 1) < 2 * standard_error_of_std(figures) ? 1 : 0;
    mean_held += std::abs(figures.mean) < 2 * standard_error_of_mean(figures) ? 1 : 0;
  }
  EXPECT_GE(std_held, 178) << "of 200 intervals at 95 %";
  EXPECT_GE(mean_held, 178) << "of 200 intervals at 95 %";
}

TEST(EffectiveNumber, CountsOnlyPairsAtLag) {
  std::mt19937_64 random(6);
  const Eigen::VectorXd values = autoregression(0.95, 400, random);
  EXPECT_LT(effective_number(values, counted(400)).of_std, 200);
  const EffectiveNumber apart = effective_number(values, 500 * counted(400));
  EXPECT_EQ(apart.of_std, 400) << "no two values are adjacent";
}

TEST(EffectiveNumber, IsCountForFewOrEqualValues) {
  EXPECT_EQ(effective_number(Eigen::Vector3d{1, 2, 3}, Eigen::Vector3i{0, 1, 2}).of_std, 3);
  EXPECT_EQ(effective_number(Eigen::VectorXd::Constant(10, 0.1), counted(10)).of_mean, 10);
  EXPECT_EQ(effective_number(Eigen::VectorXd{}, Eigen::VectorXi{}).of_std, 0);
}

TEST(Figures, HaveNoErrorBarWithoutEffectiveNumber) {
  EXPECT_TRUE(std::isnan(standard_error_of_std(compute_figures(Eigen::Vector3d{1, 2, 4}))));
  EXPECT_TRUE(std::isnan(standard_error_of_mean(compute_figures(Eigen::Vector3d{1, 2, 4}))));
}

/// A single value has no scatter, but its error must not be reported as 0.
TEST(Figures, HaveNoErrorBarForSingleValue) {
  const Figures figures = compute_figures(Eigen::VectorXd::Constant(1, 0.5), [] {
    Clusters clusters;
    clusters.start_s = Eigen::VectorXd::Zero(1);
    return clusters;
  }());
  EXPECT_EQ(figures.count, 1);
  EXPECT_TRUE(std::isnan(standard_error_of_std(figures)));
  EXPECT_TRUE(std::isnan(standard_error_of_mean(figures)));
}

TEST(Figures, DoNotCorrelateAcrossRecords) {
  std::mt19937_64 random(8);
  Clusters clusters;
  clusters.start_s.resize(400);
  clusters.start_s << Eigen::VectorXd::LinSpaced(200, 0, 19900), Eigen::VectorXd::LinSpaced(200, 0, 19900);
  const Eigen::VectorXd values = autoregression(0.9, 400, random);
  const Figures both = compute_figures(values, clusters);
  EXPECT_EQ(both.count, 400);
  EXPECT_LT(both.effective.of_std, 200);
  EXPECT_DOUBLE_EQ(standard_error_of_std(both), both.std / std::sqrt(2 * both.effective.of_std));
}

const std::vector<std::string> kEight = {"A", "B", "C", "D", "E", "F", "G", "H"};

TEST(Correlation, IsSignedAndAntisymmetric) {
  auto clusters = make_clusters(make_synthetic_run({}));
  ASSERT_TRUE(clusters);
  clusters->bias_deg_per_h = 3 * (clusters->temperature_c.col(1) - clusters->temperature_c.col(0));
  const Correlation r = correlate(*clusters, kEight);
  EXPECT_NEAR(r.gradient(0, 1), -1, 1e-12);
  EXPECT_EQ(r.gradient, -r.gradient.transpose());
  EXPECT_LE(r.gradient.cwiseAbs().maxCoeff(), 1);
}

TEST(Correlation, SkipsClustersWithoutRate) {
  Clusters clusters = *make_clusters(make_synthetic_run({}));
  clusters.bias_deg_per_h(0) = 1e6;
  clusters.bias_deg_per_h.tail(clusters.bias_deg_per_h.size() - 1) =
      -2 * clusters.rate_c_per_min.col(3).tail(clusters.bias_deg_per_h.size() - 1);
  EXPECT_NEAR(correlate(clusters, kEight).rate(3), -1, 1e-12);
}

TEST(Correlation, MatchesReferenceForRealRecord) {
  const double with_die[] = {-0.9148, 0.9996, -0.9534}, with_difference[] = {0.9456, -0.8873, 0.8487};
  for (const FreeImuAxis axis : {FreeImuAxis::x, FreeImuAxis::y, FreeImuAxis::z}) {
    const auto dataset = load_freeimu(axis);
    if (!dataset) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
    const Correlation r = correlate(*make_clusters(*dataset), dataset->gradients);
    EXPECT_NEAR(r.temperature(0), with_die[static_cast<int>(axis)], 5e-5);
    EXPECT_NEAR(r.gradient(0, 1), with_difference[static_cast<int>(axis)], 5e-5);
  }
}

}  // namespace

}  // namespace gyrotherm::data
