// SPDX-License-Identifier: Apache-2.0
#include "report/calibration_results.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "report/order.hpp"
#include "tests/report/synthetic_experiment.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kScatter_deg_per_h = 0.002;

/// Results of a whole uncompensated run: white noise about a mean, with a known uncertainty of the removed Earth rate.
class WholeRun {
 public:
  WholeRun(double mean_deg_per_h, double of_zero_deg_per_h, Eigen::Index clusters = 200, bool has_own_zero = false) {
    constexpr double kEarthRate_deg_per_h = 10, kPerPpm = 1e-6;
    data::RecordedRun run = SyntheticExperiment().rate;
    run.clusters.samples = Eigen::VectorXi::Constant(run.clusters.start_s.size(), 100);
    std::vector<Eigen::Index> rows;
    for (Eigen::Index k = 0; k < clusters; ++k) rows.push_back(k);
    run.clusters = pick_clusters(run.clusters, rows);
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal(0, kScatter_deg_per_h);
    for (double& bias : run.clusters.bias_deg_per_h) bias = normal(random);
    run.clusters.bias_deg_per_h.array() += mean_deg_per_h - run.clusters.bias_deg_per_h.mean();
    run.dataset.has_own_reference = has_own_zero;
    run.dataset.bias_zero = has_own_zero ? std::string(data::kOwnReference) : run.dataset.bias_zero;
    if (!has_own_zero) run.dataset.earth_rate_deg_per_h = kEarthRate_deg_per_h;
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

TEST(WholeRun, RootMeanSquareHasUncertaintyOfReferenceWhenMeanDominates) {
  const WholeRun run(0.1, 0.003);
  const ReportedValue rmse = run.value("rmse"), mean = run.value("mean");
  EXPECT_GE(mean.standard_uncertainty, 0.003);
  EXPECT_NEAR(rmse.standard_uncertainty, mean.standard_uncertainty, 1e-3 * mean.standard_uncertainty);
  EXPECT_GT(rmse.degrees_of_freedom, 1e6) << "the uncertainty of the bias reference is of type B";
  EXPECT_LT(run.value("std").standard_uncertainty, 0.0003) << "a STD does not depend on the bias reference";
}

/// The root mean square is least for a mean of 0, but an uncertain bias reference still changes it. The expected change
/// comes from Monte Carlo draws.
TEST(WholeRun, RootMeanSquareHasUncertaintyOfReferenceWhenMeanIsZero) {
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

TEST(WholeRun, OmitsStandardDeviationOfSingleMean) {
  const WholeRun run(0.1, 0.003, 1);
  EXPECT_EQ(run.column("std"), nullptr);
  EXPECT_EQ(run.value("mean").value, 0.1);
  for (const char* quantity : {"mean", "rmse"}) EXPECT_FALSE(run.value(quantity).expanded() > 0) << quantity;
}

TEST(WholeRun, HasNoUncertaintyIfZeroIsUnknown) {
  for (const double mean_deg_per_h : {0.0, 0.1}) {
    const WholeRun known(mean_deg_per_h, 0, 200), unknown(mean_deg_per_h, 0, 200, true);
    for (const char* quantity : {"mean", "rmse"}) {
      EXPECT_TRUE(std::isfinite(known.value(quantity).expanded())) << quantity << ": the Earth rate is exact";
      EXPECT_EQ(unknown.value(quantity).value, known.value(quantity).value) << quantity;
      EXPECT_TRUE(std::isnan(unknown.value(quantity).expanded())) << quantity;
    }
    EXPECT_EQ(unknown.value("std").standard_uncertainty, known.value("std").standard_uncertainty);
  }
}

/// Returns a linear model that uses only A. It was trained on the given run, one year after the calibration of A.
model::Model plane_in_a(const std::string& run_id) {
  constexpr double kSlope_deg_per_h_per_k = 0.004;
  model::Model model;
  model.inputs = "A";
  model.method = "linear";
  model.terms = {data::temperature_term("A")};
  model.scaling = {Eigen::RowVectorXd::Zero(1), Eigen::RowVectorXd::Ones(1)};
  model.target_std_deg_per_h = 1;
  model.function = methods::LinearModel{Eigen::VectorXd::Constant(1, kSlope_deg_per_h_per_k), 0};
  model.input_min = Eigen::RowVectorXd::Constant(1, -100);
  model.input_max = Eigen::RowVectorXd::Constant(1, 100);
  model.trained_on.resize(1);
  model.trained_on.front().run_id = run_id;
  model.trained_on.front().to_s = std::numeric_limits<double>::infinity();
  model.uncertainty = {.budget = {.averaging_s = 3600,
                                  .rows = {{.source = model::Source::turn_on, .standard_uncertainty = 1e-4},
                                           {.source = model::Source::thermometer_drift,
                                            .of = "A",
                                            .evaluation = model::Evaluation::b,
                                            .standard_uncertainty = 0.05,
                                            .sensitivity = kSlope_deg_per_h_per_k}}},
                       .sensitivities = {},
                       .added_noise_deg_per_h = 0};
  return model;
}

/// Within four years of its calibration, a thermometer drifts twice as far as within one year.
TEST(CompensatedMean, IncludesThermometerDriftSinceTraining) {
  SyntheticExperiment experiment;
  data::RecordedRun &trained = experiment.rate, &later = experiment.random;
  later.dataset.started_utc = std::chrono::days(4 * 365 + 1);
  later.dataset.thermometer_uncertainty.assign(
      8, {.drift_in_a_year = Kelvins{0.05}, .calibrated = std::chrono::sys_days{}});
  CalibrationReport report;
  const auto added =
      add_results(report, {.label = "x", .runs = {trained, later}, .left = plane_in_a(trained.dataset.run_id)});
  ASSERT_TRUE(added) << text(added.error());
  ASSERT_EQ(report.budgets.size(), 2u) << "one budget per record";
  const auto check = [&](const std::string& run, double drift_k) {
    const auto budget = std::ranges::find(report.budgets, run, &ReportedBudget::run);
    ASSERT_NE(budget, report.budgets.end());
    EXPECT_NEAR(budget->budget.rows.back().standard_uncertainty, drift_k, 1e-12);
    EXPECT_FALSE(budget->budget.rows.back().assumed);
    const auto table = std::ranges::find_if(
        report.results, [&](const ResultTable& one) { return one.key == "compensated_mean" && one.run == run; });
    ASSERT_NE(table, report.results.end());
    const ReportedValue& value = find_column(*table, "compensated_bias")->values.front();
    EXPECT_NEAR(value.standard_uncertainty, std::hypot(1e-4, 0.004 * drift_k), 1e-12);
    EXPECT_DOUBLE_EQ(value.expanded(), combined(budget->budget.rows).expanded_deg_per_h)
        << "U equals the root sum of squares of the table";
  };
  check(trained.dataset.run_id, 0.05);
  check(later.dataset.run_id, std::hypot(0.05, 0.1));
}

/// A model trained up to 20 °C is used in a run up to 60 °C.
TEST(CompensatedMean, IncludesUncertaintyOfUseOutsideTrainedRange) {
  const SyntheticExperiment experiment;
  model::Model left = plane_in_a("another run");
  left.uncertainty->budget.rows.push_back(
      {.source = model::Source::model_form, .standard_uncertainty = 0.003, .degrees_of_freedom = 12});
  const auto reported = [&](double highest_c) {
    left.input_max.setConstant(highest_c);
    CalibrationReport report;
    const auto added = add_results(report, {.label = "x", .runs = {experiment.random}, .left = left});
    EXPECT_TRUE(added) << text(added.error());
    return report;
  };
  const CalibrationReport inside = reported(100), outside = reported(20);
  ASSERT_EQ(inside.verifications.size(), 1u);
  ASSERT_EQ(outside.verifications.size(), 1u);
  EXPECT_EQ(inside.verifications.front().outside, 0);
  const ModelVerification& found = outside.verifications.front();
  EXPECT_EQ(found.run, experiment.random.dataset.run_id);
  EXPECT_EQ(found.stage, Stage::as_left);
  EXPECT_EQ(found.clusters, experiment.random.clusters.start_s.size());
  EXPECT_GT(found.outside, 0);
  EXPECT_LT(found.outside, found.clusters);
  EXPECT_EQ(found.farthest_term, "A");
  const auto u = [](const CalibrationReport& report) {
    const auto table = std::ranges::find(report.results, "compensated_mean", &ResultTable::key);
    return find_column(*table, "compensated_bias")->values.front();
  };
  const model::BudgetRow& row = outside.budgets.front().budget.rows.back();
  EXPECT_EQ(row.source, model::Source::extrapolation);
  EXPECT_EQ(inside.budgets.front().budget.rows.back().source, model::Source::model_form);
  EXPECT_NEAR(u(outside).standard_uncertainty, std::hypot(u(inside).standard_uncertainty, row.standard_uncertainty),
              1e-12);
  EXPECT_DOUBLE_EQ(u(outside).expanded(), combined(outside.budgets.front().budget.rows).expanded_deg_per_h);
}

/// The bounds of the share and the caution about the intervals never contradict each other.
TEST(CoverageBounds, AgreeWithVerdictOnIntervals) {
  data::RecordedRun run = SyntheticExperiment().random;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0, kScatter_deg_per_h);
  for (Eigen::Index k = 0; k < run.clusters.bias_deg_per_h.size(); ++k)
    run.clusters.bias_deg_per_h(k) = 0.004 * run.clusters.temperature_c(k, 0) + normal(random);
  int holding = 0, failing = 0;
  for (const double in_scatter : {0.01, 0.1, 0.3, 0.6, 0.7, 0.8, 0.9, 1.0, 2.0, 10.0}) {
    SCOPED_TRACE(in_scatter);
    model::Model left = plane_in_a("another run");
    left.uncertainty->budget.rows = {
        {.source = model::Source::turn_on, .standard_uncertainty = in_scatter * kScatter_deg_per_h}};
    CalibrationReport report;
    ASSERT_TRUE(add_results(report, {.label = "x", .runs = {run}, .left = left}));
    const ModelVerification& found = report.verifications.front();
    ASSERT_TRUE(found.coverage && found.verdict.intervals_hold);
    const auto table = std::ranges::find(report.results, "coverage", &ResultTable::key);
    ASSERT_NE(table, report.results.end());
    const Column* high = find_column(*table, "share_high");
    ASSERT_NE(high, nullptr);
    EXPECT_EQ(*found.verdict.intervals_hold, high->values.front().value >= found.coverage->nominal);
    ++(*found.verdict.intervals_hold ? holding : failing);
  }
  EXPECT_GT(holding, 0);
  EXPECT_GT(failing, 0);
}

/// Hold biases and the compensated mean contain an unknown constant; differences between holds do not.
TEST(UnknownZero, LeavesUncertaintyOnlyToDifferences) {
  const auto reported = [](bool has_own_zero) {
    data::RecordedRun run = SyntheticExperiment(9).rate;
    run.dataset.has_own_reference = has_own_zero;
    if (has_own_zero) run.dataset.bias_zero = data::kOwnReference;
    CalibrationReport report{.bias_zero = run.dataset.bias_zero};
    const auto added = add_results(report, {.label = "x", .runs = {run}, .left = plane_in_a("another run")});
    EXPECT_TRUE(added) << text(added.error());
    return report;
  };
  const CalibrationReport known = reported(false), unknown = reported(true);
  EXPECT_FALSE(has_unknown_zero(known));
  EXPECT_TRUE(has_unknown_zero(unknown));
  EXPECT_EQ(known.budgets.size(), 1u);
  EXPECT_TRUE(unknown.budgets.empty());
  EXPECT_FALSE(unknown.verifications.front().coverage);
  EXPECT_FALSE(unknown.verifications.front().verdict.intervals_hold);
  std::set<std::string> without;
  int with = 0;
  for (const ResultTable& table : unknown.results) {
    EXPECT_NE(table.key, "coverage");
    for (const Column& column : table.columns)
      for (const ReportedValue& value : column.values) {
        if (!depends_on_bias_reference(column.quantity)) {
          with += std::isfinite(value.expanded()) ? 1 : 0;
          continue;
        }
        EXPECT_TRUE(has_unknown_zero(unknown, table, column.quantity));
        EXPECT_TRUE(std::isfinite(value.value)) << table.key;
        EXPECT_TRUE(std::isnan(value.expanded())) << table.key;
        without.insert(table.key);
      }
  }
  EXPECT_EQ(without, (std::set<std::string>{"stabilised_bias", "whole_run", "compensated_mean"}));
  EXPECT_GT(with, 4) << "temperatures, retrace, sensitivities and STD";
  const auto is_retrace = [](const ResultTable& table) { return table.key == "retrace"; };
  const auto changes = std::ranges::find_if(unknown.results, is_retrace);
  ASSERT_NE(changes, unknown.results.end());
  EXPECT_TRUE(std::isfinite(find_column(*changes, "change")->values.front().expanded()));
}

/// The report compares the raw bias with the compensated one, so both are of the clusters with a residual.
TEST(WholeRun, IsOfSameClustersBeforeAndAfterCompensation) {
  data::RecordedRun run = SyntheticExperiment().random;
  run.clusters.bias_deg_per_h(0) += 100;
  model::Model left = plane_in_a("another run");
  left.terms = {data::rate_term("A")};
  CalibrationReport report;
  ASSERT_TRUE(add_results(report, {.label = "x", .runs = {run}, .left = left}));
  int tables = 0;
  for (const ResultTable& table : report.results) {
    if (table.key != "whole_run") continue;
    ++tables;
    EXPECT_LT(find_column(table, "largest")->values.front().value, 50) << name(table.stage);
  }
  EXPECT_EQ(tables, 2);
}

/// The two positions have the rates r± = b ± Ω. b is half of their sum for any scale factor; Ω is proportional to the
/// scale factor.
TEST(TwoPositions, GiveEarthRateUncertaintyOfScaleFactor) {
  constexpr double kEarthRate_deg_per_h = 10, kBias_deg_per_h = 0.1;
  data::RecordedRun run = SyntheticExperiment(9).rate;
  auto& segments = run.dataset.segments;
  const Celsius at = segments.front().target;
  int holds = 0;
  for (auto& segment : segments)
    if (segment.hold && segment.target == at) segment.unit.turned = ++holds % 2 == 0;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(kBias_deg_per_h, 1e-4);
  for (Eigen::Index k = 0; k < run.clusters.segment.size(); ++k) {
    const bool turned = segments[static_cast<std::size_t>(run.clusters.segment(k))].unit.turned;
    run.clusters.bias_deg_per_h(k) = normal(random) + (turned ? -kEarthRate_deg_per_h : kEarthRate_deg_per_h);
  }
  const auto reported = [&](const std::optional<double>& ppm, const char* quantity) {
    run.dataset.gyro_uncertainty.scale_factor_uncertainty_ppm = ppm;
    CalibrationReport report;
    EXPECT_TRUE(add_results(report, {.label = "x", .runs = {run}}));
    const auto table = std::ranges::find(report.results, "two_position", &ResultTable::key);
    return table == report.results.end() ? ReportedValue{} : find_column(*table, quantity)->values.front();
  };
  const ReportedValue exact = reported(0, "earth_rate"), with_scale_error = reported(50, "earth_rate");
  EXPECT_NEAR(with_scale_error.value, kEarthRate_deg_per_h, 1e-4);
  EXPECT_GT(exact.standard_uncertainty, 0);
  EXPECT_LT(exact.standard_uncertainty, 5e-5);
  EXPECT_NEAR(with_scale_error.standard_uncertainty,
              std::hypot(exact.standard_uncertainty, 50e-6 * with_scale_error.value), 1e-12);
  EXPECT_NEAR(reported(std::nullopt, "earth_rate").standard_uncertainty,
              std::hypot(exact.standard_uncertainty, 10e-6 * with_scale_error.value), 1e-12)
      << "a scale-factor uncertainty of 10 ppm is assumed";
  EXPECT_EQ(reported(50, "bias").standard_uncertainty, reported(0, "bias").standard_uncertainty);
}

/// A hold without a bias must not let a limit pass.
TEST(StabilisedBias, KeepsRowOfHoldWithoutValue) {
  const auto judged = [](const data::RecordedRun& run, const char* key, const char* quantity) {
    CalibrationReport report;
    EXPECT_TRUE(add_results(report, {.label = "x", .runs = {run}}));
    apply_limits(report, {{.quantity = std::string(key) + "." + quantity, .at_most = 1e9}}, DecisionRule::simple);
    const auto table = std::ranges::find(report.results, key, &ResultTable::key);
    const auto rows = table == report.results.end() ? std::vector<ReportedValue>() : table->columns.back().values;
    const auto unknown = std::ranges::count_if(rows, [](const ReportedValue& one) { return std::isnan(one.value); });
    return std::tuple(rows.size(), unknown, report.conformity.front().verdict);
  };
  data::RecordedRun run = SyntheticExperiment(9).rate;
  const auto [holds, no_unknown, passes] = judged(run, "stabilised_bias", "bias");
  ASSERT_GT(holds, 1U);
  EXPECT_EQ(no_unknown, 0);
  EXPECT_EQ(passes, Verdict::pass);
  int last_hold = 0;
  for (std::size_t i = 0; i < run.dataset.segments.size(); ++i)
    if (run.dataset.segments[i].hold) last_hold = static_cast<int>(i);
  for (Eigen::Index k = 0; k < run.clusters.segment.size(); ++k)
    if (run.clusters.segment(k) == last_hold) run.clusters.bias_deg_per_h(k) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judged(run, "stabilised_bias", "bias"), std::tuple(holds, 1, Verdict::not_known));
}

/// Returns nine clusters of 100 s. The bias is missing in the clusters 3 to 5, the temperatures only in the cluster 7.
data::RecordedRun nine_clusters() {
  constexpr Eigen::Index kRows = 18;
  data::RecordedRun run = SyntheticExperiment().rate;
  run.clusters.samples = Eigen::VectorXi::Constant(run.clusters.start_s.size(), 100);
  run.clusters = pick_clusters(run.clusters, {0, 1, 2, 6, 8});
  run.dataset.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, 850);  // two rows per cluster
  run.dataset.temperature_c =
      Eigen::MatrixXd::Constant(kRows, static_cast<Eigen::Index>(run.dataset.thermometers.size()), 20);
  run.dataset.temperature_c.row(8).setConstant(21);  // the second row of cluster 4 is missing
  run.dataset.temperature_c.row(9).setConstant(std::numeric_limits<double>::quiet_NaN());
  run.dataset.temperature_c.middleRows(14, 2).setConstant(std::numeric_limits<double>::quiet_NaN());
  run.dataset.set_point_c = Eigen::VectorXd::Constant(kRows, 25);
  run.dataset.moment_s = run.dataset.time_s;
  run.dataset.bias_deg_per_h = Eigen::VectorXd::Zero(kRows);
  run.dataset.segment = run.dataset.cycle = Eigen::VectorXi::Constant(kRows, -1);
  return run;
}

TEST(Courses, BreakAtMissingReadings) {
  CalibrationReport report;
  ASSERT_TRUE(add_results(report, {.label = "x", .runs = {nine_clusters()}}));
  int lines = 0;
  for (const FigureData& figure : report.figures) {
    for (const FigureLine& line : figure.lines) {
      if (figure.logarithmic) continue;
      ++lines;
      if (line.key == "set_point") {
        EXPECT_EQ(line.x.size(), 9u) << "a set point in each cluster";
        continue;
      }
      const bool is_bias = figure.key == "bias_course";
      ASSERT_EQ(line.x.size(), is_bias ? 7u : 9u) << figure.key;
      const std::size_t gap = is_bias ? 3 : 7;
      EXPECT_DOUBLE_EQ(line.x[gap], (is_bias ? 300.0 : 700.0) / 3600);
      EXPECT_TRUE(std::isnan(line.y[gap])) << figure.key << " " << line.detail;
      if (!is_bias) {
        EXPECT_EQ(line.y[3], 20) << "recorded while the bias was missing";
        EXPECT_EQ(line.y[4], 21) << "the mean of the row that has a reading";
      }
    }
  }
  EXPECT_EQ(lines, 1 + 8 + 1);
}

}  // namespace
}  // namespace gyrotherm::report
