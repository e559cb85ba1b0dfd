// SPDX-License-Identifier: Apache-2.0
#include "report/calibration_results.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/report/synthetic_experiment.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kScatter_deg_per_h = 0.002;

/// The whole run uncompensated, of white noise about a mean, where the Earth's rate that was taken away is known to so
/// much.
class WholeRun {
 public:
  WholeRun(double mean_deg_per_h, double of_zero_deg_per_h, Eigen::Index clusters = 200) {
    constexpr double kEarthRate_deg_per_h = 10, kPerPpm = 1e-6;
    data::RecordedRun run = SyntheticExperiment().rate;
    run.clusters.samples = Eigen::VectorXi::Constant(run.clusters.start_s.size(), 100);
    std::vector<Eigen::Index> rows;
    for (Eigen::Index k = 0; k < clusters; ++k) rows.push_back(k);
    run.clusters = pick(run.clusters, rows);
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal(0, kScatter_deg_per_h);
    for (double& bias : run.clusters.bias_deg_per_h) bias = normal(random);
    run.clusters.bias_deg_per_h.array() += mean_deg_per_h - run.clusters.bias_deg_per_h.mean();
    run.dataset.earth_rate_deg_per_h = kEarthRate_deg_per_h;
    run.dataset.gyro_uncertainty.scale_factor_uncertainty_ppm = of_zero_deg_per_h / kEarthRate_deg_per_h / kPerPpm;
    const auto added = add_results(report_, {.label = "x", .runs = {run}});
    EXPECT_TRUE(added) << text(added.error());
  }
  [[nodiscard]] const Column* column(const char* quantity) const {
    const auto table = std::ranges::find(report_.results, "whole_run", &ResultTable::key);
    return table == report_.results.end() ? nullptr : find_column(*table, quantity);
  }
  [[nodiscard]] ReportedValue value(const char* quantity) const { return column(quantity)->values.front(); }

 private:
  CalibrationReport report_;
};

TEST(WholeRun, OfAGreatMeanIsAsUncertainAsItsZero) {
  const WholeRun run(0.1, 0.003);
  const ReportedValue rmse = run.value("rmse"), mean = run.value("mean");
  EXPECT_GE(mean.standard_uncertainty, 0.003);
  EXPECT_NEAR(rmse.standard_uncertainty, mean.standard_uncertainty, 1e-3 * mean.standard_uncertainty);
  EXPECT_GT(rmse.degrees_of_freedom, 1e6) << "the zero is of type B";
  EXPECT_LT(run.value("std").standard_uncertainty, 0.0003) << "which the zero does not move";
}

/// Least where the mean is 0, a root mean square is moved by the zero all the same: by how much draws of it tell.
TEST(WholeRun, OfNoMeanKnowsItsZeroToo) {
  for (const double in_scatter : {0.2, 1.0, 2.0, 5.0}) {
    SCOPED_TRACE(in_scatter);
    const double of_zero = in_scatter * kScatter_deg_per_h;
    const WholeRun run(0, of_zero);
    const double r = run.value("rmse").value;
    std::mt19937_64 random(6);
    std::normal_distribution<double> normal(0, of_zero);
    double squares = 0;
    constexpr int kDraws = 100000;
    for (int draw = 0; draw < kDraws; ++draw) squares += std::pow(std::hypot(r, normal(random)) - r, 2);
    const double by_zero = std::sqrt(std::pow(run.value("rmse").standard_uncertainty, 2) -
                                     std::pow(run.value("std").standard_uncertainty, 2));
    EXPECT_NEAR(by_zero, std::sqrt(squares / kDraws), 0.1 * by_zero);
    EXPECT_LT(by_zero, of_zero);
  }
}

TEST(WholeRun, OfASingleMeanSaysNothingOfScatter) {
  const WholeRun run(0.1, 0.003, 1);
  EXPECT_EQ(run.column("std"), nullptr);
  EXPECT_EQ(run.value("mean").value, 0.1);
  for (const char* quantity : {"mean", "rmse"}) EXPECT_FALSE(run.value(quantity).expanded() > 0) << quantity;
}

TEST(Courses, AreNotDrawnAcrossWhatIsMissing) {
  data::RecordedRun run = SyntheticExperiment().rate;
  run.clusters.samples = Eigen::VectorXi::Constant(run.clusters.start_s.size(), 100);
  run.clusters = pick(run.clusters, {0, 1, 2, 6, 7, 8});
  CalibrationReport report;
  ASSERT_TRUE(add_results(report, {.label = "x", .runs = {run}}));
  int lines = 0;
  for (const FigureData& figure : report.figures)
    for (const FigureLine& line : figure.lines) {
      if (figure.logarithmic) continue;
      ++lines;
      ASSERT_EQ(line.x.size(), 7u) << figure.key;
      EXPECT_DOUBLE_EQ(line.x[3], 300.0 / 3600);
      EXPECT_TRUE(std::isnan(line.y[3])) << figure.key << " " << line.detail;
    }
  EXPECT_EQ(lines, 1 + 8 + 1);
}

}  // namespace
}  // namespace gyrotherm::report
