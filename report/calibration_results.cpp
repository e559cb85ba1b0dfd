// SPDX-License-Identifier: Apache-2.0
#include "report/calibration_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "analysis/data/distributions.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/model/characterisation.hpp"
#include "analysis/model/uncertainty.hpp"
#include "analysis/model/verification.hpp"
#include "core/quantity.hpp"
#include "report/plot/plot.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

ReportedValue exact_value(double value) { return {.value = value}; }

/// Combines a type A uncertainty with degrees of freedom and a type B one with infinitely many. If one of them is
/// unknown (NaN), so is that of the value.
ReportedValue make_value(double value, double u, double degrees_of_freedom, double u_type_b = 0) {
  const double combined = std::hypot(u, u_type_b);
  if (!std::isfinite(value) || !(combined > 0)) return exact_value(value);
  const double freedom = u > 0 ? std::max(1.0, degrees_of_freedom) * std::pow(combined / u, 4) : kInfinite;
  return value_with_uncertainty(value, combined, freedom);
}

ReportedValue make_value(const model::MeasuredValue& figure, double u_type_b = 0) {
  return make_value(figure.value, figure.u, figure.degrees_of_freedom, u_type_b);
}

/// Returns the combined standard uncertainty √Σ(c u)² of a budget's rows.
double combined_standard(const std::vector<model::BudgetRow>& rows) { return combined(rows).standard_deg_per_h; }

Column column(std::string quantity, std::string unit, std::vector<ReportedValue> values = {}) {
  return {.quantity = std::move(quantity), .unit = std::move(unit), .values = std::move(values)};
}

/// Target for the results of one record at one stage, with the uncertainty of the bias reference.
struct ResultTarget {
  CalibrationReport& report;
  std::string axis, run;
  Stage stage{};
  bool in_sample{};
  /// Type B uncertainty that the bias reference causes in each quantity that depends on it, °/h. NaN if the reference
  /// is a mean of the record: the zero is then unknown, and these quantities have no uncertainty.
  double u_reference{};
};

/// Adds a result table unless it has no rows. A row without a value remains, because a limit applies to it.
void add(const ResultTarget& of, Group group, std::string key, std::vector<Column> columns, std::string detail = {}) {
  if (columns.front().values.empty()) return;
  of.report.results.push_back({.group = group,
                               .key = std::move(key),
                               .axis = of.axis,
                               .stage = of.stage,
                               .run = of.run,
                               .in_sample = of.in_sample,
                               .detail = std::move(detail),
                               .columns = std::move(columns)});
}

/// Selects the value before or after compensation, depending on the stage.
const model::MeasuredValue& select_stage(const ResultTarget& of, const model::BeforeAfter& figures) {
  return of.stage == Stage::uncompensated ? figures.before : figures.after;
}

void add_warm_ups(const ResultTarget& of, const std::vector<model::WarmUp>& warm_ups) {
  Column set_point = column("set_point", "°C"), within = column("within", "°/h"), duration = column("duration", "s");
  for (const model::WarmUp& one : warm_ups) {
    set_point.values.push_back(exact_value(one.set_point_c));
    within.values.push_back(exact_value(select_stage(of, one.within).value));
    duration.values.push_back(exact_value(select_stage(of, one.seconds).value));
  }
  add(of, Group::warm_up, "warm_up", {std::move(set_point), std::move(within), std::move(duration)});
}

/// Returns the uncertainty of the mean of the block's thermometers, K: calibration and drift until the run, assumed
/// fully correlated.
double temperature_uncertainty_k(const data::Dataset& dataset) {
  double sum = 0;
  const std::vector<std::string> block = data::block_thermometers(dataset);
  for (const std::string& name : block)
    sum += combined_standard(
        model::budget_of_thermometer(dataset, {.thermometer = name, .mean = 1, .rms = 1, .greatest = 1}));
  return block.empty() ? 0 : sum / static_cast<double>(block.size());
}

void add_stabilised(const ResultTarget& of, const std::vector<model::StabilisedBias>& holds, double temperature_u_k) {
  Column set_point = column("set_point", "°C"), temperature = column("temperature", "°C"), bias = column("bias", "°/h");
  for (const model::StabilisedBias& hold : holds) {
    const model::MeasuredValue& found = select_stage(of, hold.bias);
    if (hold.turned) continue;
    set_point.values.push_back(exact_value(hold.set_point_c));
    temperature.values.push_back(make_value(hold.temperature_c, 0, kInfinite, temperature_u_k));
    bias.values.push_back(make_value(found, of.u_reference));
  }
  add(of, Group::bias, "stabilised_bias", {std::move(set_point), std::move(temperature), std::move(bias)});
}

/// Adds bias and Earth rate from two positions. The Earth rate has the uncertainty of the scale factor; the bias, the
/// mean of both positions, is free of it.
void add_two_positions(const ResultTarget& of, const std::vector<model::TwoPosition>& found,
                       const data::Dataset& dataset) {
  Column set_point = column("set_point", "°C"), bias = column("bias", "°/h"), rate = column("earth_rate", "°/h");
  for (const model::TwoPosition& one : found) {
    set_point.values.push_back(exact_value(one.set_point_c));
    bias.values.push_back(make_value(select_stage(of, one.bias)));
    const model::MeasuredValue& earth_rate = select_stage(of, one.earth_rate);
    rate.values.push_back(
        make_value(earth_rate, combined_standard({model::budget_of_scale_factor(dataset, earth_rate.value)})));
  }
  add(of, Group::bias, "two_position", {std::move(set_point), std::move(bias), std::move(rate)});
}

void add_retraces(const ResultTarget& of, const std::vector<model::Retrace>& retraces) {
  Column set_point = column("set_point", "°C"), change = column("change", "°/h");
  for (const model::Retrace& one : retraces) {
    set_point.values.push_back(exact_value(one.set_point_c));
    change.values.push_back(make_value(select_stage(of, one.change)));
  }
  add(of, Group::bias, "retrace", {std::move(set_point), std::move(change)});
}

/// Adds a result that consists of a single value.
void add_single_value(const ResultTarget& of, Group group, const char* key, const char* unit,
                      const ReportedValue& value, std::string detail = {}) {
  if (std::isfinite(value.value)) add(of, group, key, {column(key, unit, {value})}, std::move(detail));
}

void add_sensitivities(const ResultTarget& of, const model::Characterisation& found) {
  add_single_value(of, Group::sensitivity, "temperature_sensitivity", "°/h/K",
                   make_value(select_stage(of, found.temperature)));
  add_single_value(of, Group::sensitivity, "ramp_sensitivity", "°/h/(K/min)", make_value(select_stage(of, found.ramp)));
  add_single_value(of, Group::sensitivity, "gradient_sensitivity", "°/h/K",
                   make_value(select_stage(of, found.of_gradient)), found.gradient);
}

void add_hysteresis(const ResultTarget& of, const std::vector<model::HysteresisPoint>& points) {
  Column temperature = column("temperature", "°C"), width = column("width", "°/h");
  for (const model::HysteresisPoint& point : points) {
    temperature.values.push_back(exact_value(point.temperature_c));
    width.values.push_back(make_value(select_stage(of, point.width)));
  }
  add(of, Group::hysteresis, "hysteresis", {std::move(temperature), std::move(width)});
}

void add_noise(const ResultTarget& of, const data::HoldNoise& noise) {
  constexpr std::array<std::pair<const char*, const char*>, data::kNoiseTerms> kTerms{{{"quantisation", "″"},
                                                                                       {"angle_random_walk", "°/√h"},
                                                                                       {"bias_instability", "°/h"},
                                                                                       {"rate_random_walk", "°/h/√h"},
                                                                                       {"rate_ramp", "°/h/h"}}};
  if (noise.curve.empty()) return;
  for (const data::NoiseCoefficient& coefficient : noise.fit.coefficients) {
    const auto& [key, unit] = kTerms[static_cast<std::size_t>(coefficient.term)];
    if (coefficient.seen)
      add_single_value(of, Group::random_drift, key, unit,
                       make_value(coefficient.value, coefficient.error,
                                  model::degrees_of_freedom_for(coefficient.value, coefficient.error)));
  }
}

/// Returns the standard uncertainty that an uncertain bias reference (standard uncertainty u) causes in a root mean
/// square r of values with mean m. A shift δ changes r to √(r² + 2mδ + δ²). To first order the effect is |m|/r·u, but
/// that is 0 at m = 0, where r has its minimum; there the mean square of the second order is ¾u⁴/r². For u > r the
/// series is not sufficient at any order. The function therefore returns the root mean square of the change over a
/// normal δ, by three-point Gauss-Hermite quadrature: −√3·u, 0 and √3·u with weights 1/6, 2/3 and 1/6. The result never
/// exceeds u.
double rmse_reference_uncertainty(const data::Figures& figures, double u_reference) {
  const double farthest = std::numbers::sqrt3 * u_reference;
  const auto change = [&](double shift) {
    const double square = std::pow(figures.rmse, 2) + shift * (2 * figures.mean + shift);
    return std::sqrt(std::max(0.0, square)) - figures.rmse;
  };
  constexpr double kWeight = 1.0 / 6;
  return std::sqrt(kWeight) * std::hypot(change(-farthest), change(farthest));
}

/// Returns a root mean square with the uncertainty that results from standard deviation, mean and bias reference. The
/// errors of standard deviation and mean are independent.
ReportedValue make_rmse(const data::Figures& figures, double u_reference) {
  if (!(figures.rmse > 0) || std::isnan(u_reference)) return exact_value(figures.rmse);
  const double of_std = figures.std / figures.rmse, of_mean = figures.mean / figures.rmse;
  const model::CombinedUncertainty all =
      model::combined({{.standard_uncertainty = standard_error_of_std(figures),
                        .sensitivity = of_std,
                        .degrees_of_freedom = std::max(1.0, figures.effective.of_std - 1)},
                       {.standard_uncertainty = standard_error_of_mean(figures),
                        .sensitivity = of_mean,
                        .degrees_of_freedom = std::max(1.0, figures.effective.of_mean - 1)},
                       {.standard_uncertainty = rmse_reference_uncertainty(figures, u_reference)}});
  if (!(all.standard_deg_per_h > 0)) return exact_value(figures.rmse);
  return value_with_uncertainty(figures.rmse, all.standard_deg_per_h, all.degrees_of_freedom);
}

void add_whole_run(const ResultTarget& of, const data::Figures& figures) {
  if (figures.count == 0) return;
  const auto& [of_std, of_mean] = figures.effective;
  std::vector<Column> columns{
      column("mean", "°/h", {make_value(figures.mean, standard_error_of_mean(figures), of_mean - 1, of.u_reference)})};
  if (figures.count > 1)
    columns.push_back(column("std", "°/h", {make_value(figures.std, standard_error_of_std(figures), of_std - 1)}));
  columns.push_back(column("rmse", "°/h", {make_rmse(figures, of.u_reference)}));
  columns.push_back(column("largest", "°/h", {exact_value(figures.max_abs)}));
  add(of, Group::compensation, "whole_run", std::move(columns));
}

void add_behaviour(const ResultTarget& of, const model::Characterisation& found, const data::Dataset& dataset) {
  add_warm_ups(of, found.warm_ups);
  add_stabilised(of, found.stabilised, temperature_uncertainty_k(dataset));
  add_two_positions(of, found.two_position, dataset);
  add_retraces(of, found.retrace);
  add_sensitivities(of, found);
  add_hysteresis(of, found.hysteresis);
}

/// Returns the budget of a model's compensated mean in a run. For a training record the budget omits the thermometer
/// drift since training. If the model was used outside its trained range, the budget has a row for it.
Result<model::Budget> make_run_budget(const model::Model& model, const data::RecordedRun& run, bool in_sample) {
  model::Budget budget = model.uncertainty->budget;
  if (!in_sample) budget.rows = model::rows_for_run(run.dataset, std::move(budget.rows));
  auto extrapolation = budget_of_extrapolation(model, *model.uncertainty, budget.rows, run.clusters);
  if (!extrapolation) return failure(extrapolation.error());
  if (*extrapolation) budget.rows.push_back(std::move(**extrapolation));
  return budget;
}

/// Adds the calibrated value of the unit: the mean of its compensated bias, with the uncertainty of the budget. The
/// budget does not apply if the zero of the bias is unknown.
void add_compensated_mean(const ResultTarget& of, const data::Figures& figures, std::optional<model::Budget> budget) {
  ReportedValue value = exact_value(figures.mean);
  if (budget && !std::isnan(of.u_reference)) {
    const model::CombinedUncertainty all = combined(budget->rows);
    value.standard_uncertainty = all.standard_deg_per_h;
    value.coverage_factor = all.coverage_factor;
    value.degrees_of_freedom = all.degrees_of_freedom;
    of.report.budgets.push_back({.axis = of.axis, .stage = of.stage, .run = of.run, .budget = std::move(*budget)});
  }
  add(of, Group::compensation, "compensated_mean", {column("compensated_bias", "°/h", {value})});
}

void add_coverage(const ResultTarget& of, const std::optional<model::Coverage>& coverage) {
  if (!coverage) return;
  std::vector<Column> columns{column("nominal_share", "1", {exact_value(coverage->nominal)}),
                              column("seen_share", "1", {exact_value(coverage->seen)})};
  if (coverage->effective > 1) {
    // The same distribution and number as those of Verdict::intervals_hold: the bounds cannot contradict the caution.
    const auto [low, high] =
        data::binomial_interval(coverage->seen * coverage->effective, coverage->effective, model::kCoverage);
    columns.push_back(column("share_low", "1", {exact_value(low)}));
    columns.push_back(column("share_high", "1", {exact_value(high)}));
  }
  add(of, Group::compensation, "coverage", std::move(columns));
}

void add_verification(const ResultTarget& of, const model::Verification& found, const data::Clusters& clusters) {
  of.report.verifications.push_back({.axis = of.axis,
                                     .stage = of.stage,
                                     .run = of.run,
                                     .verdict = found.verdict,
                                     .clusters = static_cast<int>(clusters.start_s.size()),
                                     .outside = found.outside.clusters,
                                     .farthest_term = found.outside.farthest_term,
                                     .farthest = found.outside.farthest,
                                     .coverage = found.coverage});
}

std::vector<double> to_hours(const Eigen::VectorXd& seconds) {
  std::vector<double> hours;
  for (const double second : seconds) hours.push_back(second / kSecondsPerHour);
  return hours;
}

std::vector<double> numbers(const Eigen::Ref<const Eigen::VectorXd>& values) { return {values.begin(), values.end()}; }

FigureLine allan_line(Stage stage, const data::AllanCurve& curve) {
  FigureLine line{.key = "bias", .stage = stage};
  for (const data::AllanPoint& point : curve) {
    line.x.push_back(point.tau_s);
    line.y.push_back(point.deviation_deg_per_h);
    line.error.push_back(point.error_deg_per_h);
  }
  return line;
}

/// One axis of one record, with the result of each model.
struct VerifiedRun {
  const data::RecordedRun& run;
  /// Uncompensated bias in the clusters with a residual of the last model, with which the report compares it; without a
  /// model, in all clusters.
  data::Figures raw{};
  data::HoldNoise noise{};
  struct ModelResult {
    Stage stage{};
    const model::Model* model{};
    model::Verification verification{};
    /// Absent for a model without an uncertainty.
    std::optional<model::Budget> budget{};
    data::HoldNoise noise{};
  };
  std::vector<ModelResult> models{};
};

Result<VerifiedRun> verify_run(const CalibratedAxis& axis, const data::RecordedRun& run) {
  VerifiedRun verified{.run = run,
                       .raw = compute_figures(run.clusters.bias_deg_per_h, run.clusters),
                       .noise = measure_hold_noise(run.dataset)};
  for (const auto& [stage, model] : {std::pair{Stage::as_found, &axis.found}, {Stage::as_left, &axis.left}}) {
    if (!*model) continue;
    auto verification = verify(**model, run.dataset, run.clusters);
    if (!verification) return failure(verification.error());
    std::optional<model::Budget> budget;
    if ((*model)->uncertainty) {
      auto made = make_run_budget(**model, run, verification->trained_on_this);
      if (!made) return failure(made.error());
      budget = std::move(*made);
    }
    auto noise = measure_compensated_hold_noise(run.dataset, run.clusters, verification->residual_deg_per_h);
    verified.raw = verification->raw;
    verified.models.push_back({stage, &**model, std::move(*verification), std::move(budget), std::move(noise)});
  }
  return verified;
}

/// Returns the means of a column of the record over the cluster length. Intervals without a reading are gaps. Rows
/// without a bias count too, such as those of a unit that is switched off.
FigureLine record_course(FigureLine line, const data::Dataset& dataset, double length_s,
                         const Eigen::Ref<const Eigen::VectorXd>& values) {
  constexpr double kTimeSlack = 1e-9;  // fraction of the cluster length
  std::vector<double> hours, means;
  double sum = 0, count = 0, number = 0;
  const auto finish = [&] {
    if (count > 0) {
      hours.push_back((dataset.time_s(0) + number * length_s) / kSecondsPerHour);
      means.push_back(sum / count);
    }
    sum = count = 0;
  };
  for (Eigen::Index row = 0; row < values.size(); ++row) {
    const double at = std::floor((dataset.time_s(row) - dataset.time_s(0)) / length_s + kTimeSlack);
    if (at != number) finish();
    number = at;
    if (!std::isfinite(values(row))) continue;
    sum += values(row);
    ++count;
  }
  finish();
  auto [x, y] = plot::break_at_gaps(hours, means, length_s / kSecondsPerHour);
  line.x = std::move(x);
  line.y = std::move(y);
  return line;
}

void add_courses(CalibrationReport& report, const std::string& axis, const VerifiedRun& verified) {
  const auto& [dataset, clusters] = verified.run;
  const auto course = [&clusters](FigureLine line, const Eigen::Ref<const Eigen::VectorXd>& values) {
    auto [x, y] = plot::break_at_gaps(to_hours(clusters.start_s), numbers(values), clusters.length_s / kSecondsPerHour);
    line.x = std::move(x);
    line.y = std::move(y);
    return line;
  };
  FigureData temperatures{.key = "temperatures",
                          .axis = axis,
                          .run = dataset.run_id,
                          .x_key = "time",
                          .x_unit = "h",
                          .y_key = "temperature",
                          .y_unit = "°C"};
  if (!dataset.imported)
    temperatures.lines.push_back(record_course({.key = "set_point"}, dataset, clusters.length_s, dataset.set_point_c));
  for (std::size_t k = 0; k < dataset.thermometers.size(); ++k) {
    if (!data::is_temperature(dataset.thermometers[k])) continue;
    const auto column = static_cast<Eigen::Index>(k);
    if (column < dataset.temperature_c.cols())
      temperatures.lines.push_back(record_course({.key = "temperature", .detail = dataset.thermometers[k]}, dataset,
                                                 clusters.length_s, dataset.temperature_c.col(column)));
  }
  FigureData bias = temperatures;
  bias.key = "bias_course";
  bias.y_key = "bias";
  bias.y_unit = "°/h";
  bias.lines = {course({.key = "bias"}, clusters.bias_deg_per_h)};
  for (const VerifiedRun::ModelResult& of : verified.models)
    bias.lines.push_back(course({.key = "bias", .stage = of.stage}, of.verification.residual_deg_per_h));
  report.figures.push_back(std::move(temperatures));
  report.figures.push_back(std::move(bias));
}

void add_allan_figure(CalibrationReport& report, const std::string& axis, const VerifiedRun& verified) {
  if (verified.noise.curve.empty()) return;
  FigureData figure{.key = "allan_deviation",
                    .axis = axis,
                    .run = verified.run.dataset.run_id,
                    .x_key = "averaging_time",
                    .x_unit = "s",
                    .y_key = "allan_deviation",
                    .y_unit = "°/h",
                    .logarithmic = true,
                    .lines = {allan_line(Stage::uncompensated, verified.noise.curve)}};
  for (const VerifiedRun::ModelResult& of : verified.models)
    figure.lines.push_back(allan_line(of.stage, of.noise.curve));
  report.figures.push_back(std::move(figure));
}

/// Adds the results of one record to the report. Returns the characteristics of the unit in this record by stage.
std::map<Stage, model::Characterisation> add_run(CalibrationReport& report, const std::string& axis,
                                                 const VerifiedRun& verified) {
  const auto& [dataset, clusters] = verified.run;
  const double u_reference = dataset.has_own_reference ? std::numeric_limits<double>::quiet_NaN()
                                                       : combined_standard(model::budget_of_earth_rate(dataset));
  ResultTarget of{report, axis, dataset.run_id, Stage::uncompensated, false, u_reference};
  const Eigen::VectorXd nothing =
      Eigen::VectorXd::Constant(clusters.start_s.size(), std::numeric_limits<double>::quiet_NaN());
  std::map<Stage, model::Characterisation> found{
      {Stage::uncompensated, model::characterise(dataset, clusters, nothing)}};
  add_behaviour(of, found[Stage::uncompensated], dataset);
  add_noise(of, verified.noise);
  add_whole_run(of, verified.raw);
  for (const VerifiedRun::ModelResult& one : verified.models) {
    of.stage = one.stage;
    of.in_sample = one.verification.trained_on_this;
    found[one.stage] = model::characterise(dataset, clusters, one.verification.residual_deg_per_h);
    add_behaviour(of, found[one.stage], dataset);
    add_noise(of, one.noise);
    add_whole_run(of, one.verification.compensated);
    add_compensated_mean(of, one.verification.compensated, one.budget);
    add_coverage(of, one.verification.coverage);
    add_verification(of, one.verification, clusters);
  }
  add_courses(report, axis, verified);
  add_allan_figure(report, axis, verified);
  return found;
}

/// Characteristics of the unit in all records at one stage.
struct AllRecords {
  std::vector<model::Characterisation> characterised{};
  /// True if the model of this stage was fitted to a record that contains a start of the unit.
  bool in_sample{};
};

/// Appends the characteristics of one record, `found`, to the characteristics of the previous records, `all`.
void append_stages(std::map<Stage, AllRecords>& all, std::map<Stage, model::Characterisation> found,
                   const VerifiedRun& verified) {
  for (const VerifiedRun::ModelResult& one : verified.models)
    if (one.verification.trained_on_this && !found[one.stage].warm_ups.empty()) all[one.stage].in_sample = true;
  for (auto& [stage, characterised] : found) all[stage].characterised.push_back(std::move(characterised));
}

/// Adds the turn-on repeatability over the starts of all records, per stage.
void add_turn_on(CalibrationReport& report, const std::string& axis, const std::map<Stage, AllRecords>& all) {
  for (const auto& [stage, records] : all) {
    Column set_point = column("set_point", "°C"), starts = column("starts", "1"), std = column("std_of_bias", "°/h");
    for (const model::TurnOn& one : model::turn_on_scatter(records.characterised)) {
      const double freedom = one.starts - 1;
      const double value = stage == Stage::uncompensated ? one.std_before_deg_per_h : one.std_after_deg_per_h;
      set_point.values.push_back(exact_value(one.set_point_c));
      starts.values.push_back(exact_value(one.starts));
      std.values.push_back(make_value(value, value / std::sqrt(2 * freedom), freedom));
    }
    add({report, axis, {}, stage, records.in_sample, 0}, Group::turn_on, "turn_on_repeatability",
        {std::move(set_point), std::move(starts), std::move(std)});
  }
}

}  // namespace

Result<void> add_results(CalibrationReport& report, const CalibratedAxis& axis) {
  std::map<Stage, AllRecords> all;
  const std::size_t first = report.results.size();
  for (const data::RecordedRun& run : axis.runs) {
    const auto verified = verify_run(axis, run);
    if (!verified) return failure(verified.error());
    append_stages(all, add_run(report, axis.label, *verified), *verified);
  }
  add_turn_on(report, axis.label, all);
  const auto own = report.results.begin() + static_cast<std::ptrdiff_t>(first);
  std::stable_sort(own, report.results.end(),
                   [](const ResultTable& a, const ResultTable& b) { return a.group < b.group; });
  return {};
}

}  // namespace gyrotherm::report
