// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/residual_correlation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "analysis/data/distributions.hpp"
#include "analysis/data/statistics.hpp"

namespace gyrotherm::population {
namespace {

/// Draws residuals with the autocorrelation `memory` at a lag of one step, and with the same correlation between any
/// two axes.
AxisResiduals draw_residuals(Eigen::Index rows, Eigen::Index axes, double memory, double correlation,
                             std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  AxisResiduals residuals{.axes = {},
                          .positions = Eigen::VectorXi::LinSpaced(rows, 0, static_cast<int>(rows) - 1),
                          .residual_deg_per_h = Eigen::MatrixXd(rows, axes)};
  for (Eigen::Index j = 0; j < axes; ++j) residuals.axes.push_back(std::string(1, static_cast<char>('x' + j)));
  Eigen::RowVectorXd state(axes);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double common = normal(random);
    for (double& value : state) {
      const double fresh = std::sqrt(correlation) * common + std::sqrt(1 - correlation) * normal(random);
      value = k == 0 ? fresh : memory * value + std::sqrt(1 - memory * memory) * fresh;
    }
    residuals.residual_deg_per_h.row(k) = state;
  }
  return residuals;
}

/// Relative frequencies of alarms at a level of 5 %.
struct AlarmRates {
  double pair{}, all{}, largest{};
  /// A t test that treats all rows as independent.
  double naive{};
};

AlarmRates alarm_rates(double memory, double correlation, Eigen::Index rows, int draws) {
  constexpr double kLevel = 0.05;
  AlarmRates rates;
  for (int draw = 1; draw <= draws; ++draw) {
    const auto residuals = draw_residuals(rows, 3, memory, correlation, static_cast<std::uint64_t>(draw));
    const auto found = correlate_residuals(residuals);
    const double freedom = static_cast<double>(rows) - 2, r = found.correlation(0, 1);
    const double t = std::abs(r) * std::sqrt(freedom / (1 - r * r));
    rates.pair += (found.probability(0, 1) < kLevel) / static_cast<double>(draws);
    rates.all += (found.all_probability < kLevel) / static_cast<double>(draws);
    rates.largest += (found.largest_probability < kLevel) / static_cast<double>(draws);
    rates.naive += (2 * data::students_t_probability(-t, freedom) < kLevel) / static_cast<double>(draws);
  }
  return rates;
}

TEST(ResidualCorrelation, HasNominalFalseAlarmRate) {
  // Two standard errors of a rate of 5 % are 1.1 %.
  constexpr int kDraws = 1500;
  for (const double memory : {0.0, 0.5, 0.8}) {
    SCOPED_TRACE(memory);
    const AlarmRates rates = alarm_rates(memory, 0, 400, kDraws);
    for (const double rate : {rates.pair, rates.all, rates.largest}) {
      EXPECT_GT(rate, 0.03);
      EXPECT_LT(rate, 0.07);
    }
  }
}

/// The 400 rows are worth about 42 independent pairs. A test that treats all rows as independent raises alarms in
/// nearly half of the draws.
TEST(ResidualCorrelation, HasNearlyNominalFalseAlarmRateForLongCorrelation) {
  const AlarmRates rates = alarm_rates(0.9, 0, 400, 1500);
  for (const double rate : {rates.pair, rates.all, rates.largest}) EXPECT_LT(rate, 0.09);
  EXPECT_GT(rates.naive, 0.4);
}

TEST(ResidualCorrelation, DetectsCorrelation) {
  for (const double memory : {0.0, 0.8}) {
    const AlarmRates rates = alarm_rates(memory, 0.5, 400, 100);
    EXPECT_GT(rates.all, 0.98) << memory;
    EXPECT_GT(rates.largest, 0.98) << memory;
  }
}

/// For two series with the autocorrelation φ at a lag of one step, the expected number is n(1 − φ²)/(1 + φ²).
TEST(ResidualCorrelation, EstimatesEffectiveNumberOfPairs) {
  for (const double memory : {0.0, 0.5, 0.8, 0.9}) {
    SCOPED_TRACE(memory);
    double mean = 0;
    constexpr int kDraws = 60;
    for (int draw = 1; draw <= kDraws; ++draw)
      mean +=
          correlate_residuals(draw_residuals(2000, 2, memory, 0, static_cast<std::uint64_t>(draw))).effective(0, 1) /
          kDraws;
    EXPECT_NEAR(mean / (2000 * (1 - memory * memory) / (1 + memory * memory)), 1, 0.06);
  }
}

TEST(ResidualCorrelation, UsesOnlyRowsKnownForBothAxes) {
  AxisResiduals residuals = draw_residuals(300, 3, 0.5, 0.3, 7);
  AxisResiduals picked{.axes = {"x", "y"}, .positions = {}, .residual_deg_per_h = {}};
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < 300; ++k) {
    if (k % 7 != 3 && (k < 100 || k >= 150)) {
      rows.push_back(k);
    } else {
      residuals.residual_deg_per_h(k, k % 7 == 3 ? 0 : 1) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  picked.positions = residuals.positions(rows);
  picked.residual_deg_per_h = residuals.residual_deg_per_h(rows, std::vector<Eigen::Index>{0, 1});
  const auto all = correlate_residuals(residuals), of_picked = correlate_residuals(picked);
  EXPECT_DOUBLE_EQ(all.correlation(0, 1), of_picked.correlation(0, 1));
  EXPECT_DOUBLE_EQ(all.effective(0, 1), of_picked.effective(0, 1));
  // The tests are equal for a single pair.
  EXPECT_EQ(of_picked.all_probability < 0.05, of_picked.largest_probability < 0.05);
}

TEST(ResidualCorrelation, ReportsNothingForConstantOrShortResiduals) {
  AxisResiduals residuals = draw_residuals(100, 2, 0, 0.9, 1);
  residuals.residual_deg_per_h.col(1).setConstant(0.25);
  EXPECT_EQ(correlate_residuals(residuals).all_probability, 1);
  EXPECT_EQ(correlate_residuals(draw_residuals(4, 2, 0, 0.9, 1)).largest_probability, 1);
  AxisResiduals twice = draw_residuals(100, 2, 0, 0, 1);
  twice.residual_deg_per_h.col(1) = twice.residual_deg_per_h.col(0);
  EXPECT_LT(correlate_residuals(twice).largest_probability, 1e-12);
  EXPECT_LT(correlate_residuals(twice).all_probability, 1e-12);
}

data::Clusters clusters_at(const std::vector<double>& start_s) {
  data::Clusters clusters;
  clusters.start_s = Eigen::Map<const Eigen::VectorXd>(start_s.data(), static_cast<Eigen::Index>(start_s.size()));
  return clusters;
}

TEST(ResidualCorrelation, AlignsAxesByRunTime) {
  const auto x = clusters_at({0, 100, 300}), y = clusters_at({100, 200, 300});
  const std::vector<AxisResidual> axes{{"x", x, Eigen::Vector3d{1, 2, 3}}, {"y", y, Eigen::Vector3d{4, 5, 6}}};
  const auto all = align_residuals(axes);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->positions, (Eigen::Vector4i{0, 1, 2, 3}));
  EXPECT_TRUE(std::isnan(all->residual_deg_per_h(2, 0)) && std::isnan(all->residual_deg_per_h(0, 1)));
  EXPECT_EQ(all->residual_deg_per_h(3, 0), 3);
  EXPECT_EQ(all->residual_deg_per_h(1, 1), 4);
}

TEST(ResidualCorrelation, RejectsInconsistentAxes) {
  const auto x = clusters_at({0, 100}), again = clusters_at({100, 0});
  auto longer = x;
  longer.length_s = 50;
  const Eigen::Vector2d values{1, 2};
  const auto refuses = [](const std::vector<AxisResidual>& axes) {
    const auto all = align_residuals(axes);
    return !all && all.error().kind == FaultKind::usage;
  };
  EXPECT_TRUE(refuses({{"x", x, values}}));
  EXPECT_TRUE(refuses({{"x", x, values}, {"x", x, values}}));
  EXPECT_TRUE(refuses({{"x", x, values}, {"y", longer, values}}));
  EXPECT_TRUE(refuses({{"x", x, values}, {"y", again, values}}));
  EXPECT_TRUE(refuses({{"x", x, values}, {"y", x, Eigen::Vector3d{1, 2, 3}}}));
  EXPECT_FALSE(refuses({{"x", x, values}, {"y", x, values}}));
}

}  // namespace
}  // namespace gyrotherm::population
