// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/quantity.hpp"
#include "report/plot/plot.hpp"
#include "report/plot/svg.hpp"
#include "report/views.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kBiasTitle = "Bias, °/h";
constexpr const char* kErrorTitle = "Residual, °/h";

plot::AxisStyle time_axis() { return {.title = "Time since the start of the run, h"}; }

std::vector<plot::Stretch> cycle_stretches(const ReportedRun& run) {
  std::vector<plot::Stretch> all;
  for (const auto& cycle : run.series.cycles)
    all.push_back({cycle.name, {cycle.start_s / kSecondsPerHour, cycle.end_s / kSecondsPerHour}});
  return all;
}

plot::Curve make_time_curve(const Report& report, const ReportedRun& run, const std::vector<double>& values,
                            const char* name, const char* colour) {
  auto [x, y] = plot::break_at_gaps(run.series.time_s, values, report.cluster_length_s);
  for (double& at : x) at /= kSecondsPerHour;
  return {.name = name, .colour = colour, .x = std::move(x), .y = std::move(y)};
}

plot::Plot time_plot(const Report& report, const ReportedRun& run, const std::string& id, const std::string& title) {
  return {.id = id,
          .title = title,
          .x = time_axis(),
          .stretches = cycle_stretches(run),
          .simulated = report.rig.is_virtual};
}

std::vector<plot::Band> floor_band(const ReportedRun& run) {
  const double floor = run.floor.deg_per_h;
  if (!std::isfinite(floor)) return {};
  return {{"± noise floor", {-floor, floor}}};
}

/// Name, colour and residual of a model for its curve.
struct ModelCurve {
  const char* name;
  const char* colour;
  const std::vector<double>& residual;
};

plot::Panel error_panel(const Report& report, const ReportedRun& run, const std::string& title,
                        const ModelCurve& model_curve, std::optional<plot::Range> range, double height_px) {
  plot::Panel made = plot::make_panel(
      title, kErrorTitle, {make_time_curve(report, run, model_curve.residual, model_curve.name, model_curve.colour)},
      height_px);
  made.left.range = range;
  made.bands = floor_band(run);
  return made;
}

ReportFigure before_after_figure(const Report& report, const ModelCurve& model_curve, const std::string& id) {
  const ReportedRun& run = report.rate;
  plot::Plot plot = time_plot(report, run, id, fmt::format("Bias before and after {} compensation", model_curve.name));
  plot::Panel both =
      plot::make_panel("(a) Before and after", kBiasTitle,
                       {make_time_curve(report, run, run.series.raw, "before", plot::colour::kRaw),
                        make_time_curve(report, run, model_curve.residual, model_curve.name, model_curve.colour)},
                       210);
  plot.panels = {both, error_panel(report, run, "(b) Residual, enlarged", model_curve, {}, 170)};
  const std::string caption =
      fmt::format("Bias in the {} run before and after {} compensation, and the residual enlarged; {}.", run.profile,
                  model_curve.name, in_sample_text(run));
  return {id, caption, to_svg(plot)};
}

constexpr std::size_t kMarkers = 4;

plot::Curve correlation_curve(const ReportedCorrelation& correlation, std::size_t row) {
  plot::Curve curve{.name = correlation.names[row], .colour = plot::palette(row), .width_px = 1.4};
  for (std::size_t column = 0; column < correlation.names.size(); ++column) {
    if (column == row) continue;
    curve.x.push_back(static_cast<double>(column));
    curve.y.push_back(correlation.magnitude[row][column]);
  }
  curve.marker = static_cast<plot::Marker>(1 + row % kMarkers);
  curve.hollow = row >= kMarkers;
  return curve;
}

/// Returns the range for the enlarged panel: from a multiple of 0.05 that is at least 0.025 below the threshold, to 1.
plot::Range enlarged_range(double threshold) { return {std::max(0.0, std::floor(20 * threshold - 0.5) / 20), 1.0}; }

std::vector<double> square_roots(std::vector<double> squares) {
  for (double& value : squares) value = std::sqrt(value);
  return squares;
}

plot::Curve history_curve(const ReportedModel& model, const char* name, const char* colour) {
  plot::Curve curve{
      .name = name, .colour = colour, .y = square_roots(model.tuning.swarm.history), .width_px = 1.6, .steps = true};
  for (std::size_t k = 0; k < model.tuning.swarm.history.size(); ++k) curve.x.push_back(static_cast<double>(k));
  return curve;
}

ReportFigure temperature_figure(const Report& report, const ReportedRun& run, const std::string& id) {
  const auto& [first_name, first] = run.series.thermometers_c.front();
  plot::Plot plot = time_plot(report, run, id, "Set point, block temperature and bias over time");
  plot::Curve bias = make_time_curve(report, run, run.series.raw, "bias", plot::colour::kBias);
  bias.side = plot::Side::right;
  plot::Curve set_point = make_time_curve(report, run, run.series.set_point_c, "set point", plot::colour::kSetPoint);
  set_point.dashed = true;
  const std::string block_name = "block (" + first_name + ")";
  plot::Panel only = plot::make_panel(
      "", "Temperature, °C",
      {bias, set_point, make_time_curve(report, run, first, block_name.c_str(), plot::colour::kTemperature)}, 270);
  only.left.colour = plot::colour::kTemperature;
  only.right = plot::AxisStyle{.title = kBiasTitle, .colour = plot::colour::kBias};
  plot.panels = {only};
  return {id,
          fmt::format("Chamber set point, block temperature (thermometer {}) and bias in the {} run; means over {} s.",
                      first_name, run.profile, plot::decimal(report.cluster_length_s, 0)),
          to_svg(plot)};
}

ReportFigure correlation_array(const Report& report) {
  const ReportedCorrelation& correlation = report.correlation;
  const plot::HeatMap map{.title = "Correlation of the bias with every temperature gradient",
                          .names = correlation.names,
                          .values = correlation.magnitude,
                          .threshold = correlation.threshold,
                          .caption = fmt::format("|r|; framed: above {}", plot::decimal(correlation.threshold, 2)),
                          .simulated = report.rig.is_virtual};
  return {"table-3",
          "Correlation coefficients |r| between the bias and the temperature gradients, from the training clusters "
          "only. The array is symmetric; its diagonal is zero by convention.",
          to_svg(map)};
}

ReportFigure correlation_curves(const Report& report) {
  const ReportedCorrelation& correlation = report.correlation;
  const plot::Rule threshold{"threshold " + plot::decimal(correlation.threshold, 2), correlation.threshold};
  plot::Panel whole = plot::make_panel("(a)", "|r|", {}, 200),
              enlarged = plot::make_panel("(b) Enlarged", "|r|", {}, 170);
  for (std::size_t row = 0; row < correlation.names.size(); ++row) {
    whole.curves.push_back(correlation_curve(correlation, row));
    enlarged.curves.push_back(whole.curves.back());
    enlarged.curves.back().name.clear();
  }
  whole.left.range = plot::Range{0, 1};
  enlarged.left.range = enlarged_range(correlation.threshold);
  whole.rules = {{"", threshold.value}};
  enlarged.rules = {threshold};
  const plot::Plot plot{.id = "figure-5",
                        .title = "Correlation of the bias with the gradients of each thermometer",
                        .x = {.title = "Second thermometer of the gradient", .categories = correlation.names},
                        .panels = {whole, enlarged},
                        .simulated = report.rig.is_virtual};
  return {plot.id,
          "The same coefficients as one curve per thermometer: (a) full range, (b) enlarged near the threshold.",
          to_svg(plot)};
}

std::vector<ReportFigure> rate_figures(const Report& report) {
  const auto& residual = report.rate.series.residual;
  return {
      before_after_figure(report, {"three-point", plot::colour::kThreePoint, residual.three_point}, "figure-6"),
      before_after_figure(report, {"multi-point", plot::colour::kMultiPoint, residual.multi_point}, "figure-7"),
      before_after_figure(report, {"multi-point with temperature", plot::colour::kMultiPointT, residual.multi_point_t},
                          "figure-7-with-temperature")};
}

ReportFigure random_figure(const Report& report) {
  const ReportedRun& run = report.random;
  const auto& residual = run.series.residual;
  const ModelCurve three{"three-point", plot::colour::kThreePoint, residual.three_point};
  const ModelCurve multi{"multi-point", plot::colour::kMultiPoint, residual.multi_point};
  const ModelCurve multi_t{"multi-point with temperature", plot::colour::kMultiPointT, residual.multi_point_t};
  plot::Range range =
      plot::join_ranges(plot::join_ranges(plot::value_range(three.residual), plot::value_range(multi.residual)),
                        plot::value_range(multi_t.residual));
  range = round_out(range, 3);
  plot::Plot plot = time_plot(report, run, "figure-8", "Bias of the random run before and after compensation");
  plot.panels = {plot::make_panel("(a) Before and after", kBiasTitle,
                                  {make_time_curve(report, run, run.series.raw, "before", plot::colour::kRaw),
                                   make_time_curve(report, run, multi.residual, multi.name, multi.colour),
                                   make_time_curve(report, run, multi_t.residual, multi_t.name, multi_t.colour)},
                                  210),
                 error_panel(report, run, "(b) Residual, enlarged", three, range, 120),
                 error_panel(report, run, "(c)", multi, range, 120),
                 error_panel(report, run, "(d)", multi_t, range, 120)};
  return {plot.id,
          fmt::format("Bias in the {} run, {}. (a) Before and after compensation; (b) to (d) residual of each model, "
                      "at the same scale.",
                      run.profile, in_sample_text(run)),
          to_svg(plot)};
}

ReportFigure tuning_figure(const Report& report) {
  const auto& models = report.models;
  plot::Plot plot{.id = "tuning",
                  .title = "Best fitness of the swarm over its iterations",
                  .x = {.title = "Iteration (0: the initial swarm)"},
                  .simulated = report.rig.is_virtual};
  plot.panels = {plot::make_panel(
      "", "RMSE on held-out cycles, °/h",
      {history_curve(models.three_point, "three-point", plot::colour::kThreePoint),
       history_curve(models.multi_point, "multi-point", plot::colour::kMultiPoint),
       history_curve(models.multi_point_t, "multi-point with temperature", plot::colour::kMultiPointT)},
      210)};
  return {plot.id, "Best fitness found by each swarm: root mean square error on held-out cycles.", to_svg(plot)};
}

plot::Curve allan_curve(const data::AllanCurve& points, const char* name, const char* colour) {
  plot::Curve curve{.name = name, .colour = colour};
  for (const data::AllanPoint& point : points) {
    curve.x.push_back(point.tau_s);
    curve.y.push_back(point.deviation_deg_per_h);
  }
  return curve;
}

/// Returns a curve with markers and error bars, without a line.
plot::Curve measured_curve(const data::AllanCurve& points, const char* name, const char* colour) {
  plot::Curve curve = allan_curve(points, name, colour);
  for (const data::AllanPoint& point : points) curve.error.push_back(point.error_deg_per_h);
  curve.marker = plot::Marker::circle;
  curve.line = false;
  return curve;
}

/// Returns σ of one noise term over the averaging times of the points.
plot::Curve term_line(const data::NoiseCoefficient& noise, const data::AllanCurve& points) {
  plot::Curve line{.name = {}, .colour = plot::colour::kFaintInk, .dashed = true};
  for (const data::AllanPoint& point : points) {
    line.x.push_back(point.tau_s);
    line.y.push_back(noise_deviation(noise, point.tau_s));
  }
  return line;
}

plot::Curve fit_line(const data::HoldNoise& holds) {
  plot::Curve line = allan_curve(holds.curve, "fit", plot::colour::kInk);
  line.y = fitted_deg_per_h(holds);
  line.width_px = 1.4;
  return line;
}

/// Returns the range of the measured curves. Lines of single noise terms may extend outside the panel.
plot::Range measured_range(const std::vector<plot::Curve>& curves) {
  std::vector<double> ends;
  for (const plot::Curve& curve : curves) {
    for (std::size_t k = 0; k < curve.y.size(); ++k) {
      const double error = curve.error.empty() ? 0 : curve.error[k];
      ends.insert(ends.end(), {curve.y[k], curve.y[k] + error});
    }
  }
  return plot::round_out_logarithmically(plot::find_positive_range(ends));
}

plot::Panel allan_panel(const ReportedRun& run, const std::string& title) {
  plot::Panel panel;
  panel.title = title;
  panel.left = {.title = "Allan deviation, °/h", .logarithmic = true};
  panel.height_px = 210;
  const data::HoldNoise& holds = run.noise.compensated_holds;
  plot::Curve raw = allan_curve(run.noise.raw, "run, raw", plot::colour::kRaw);
  raw.marker = plot::Marker::square;
  raw.hollow = true;
  plot::Curve compensated =
      allan_curve(run.noise.compensated.multi_point_t, "run, compensated", plot::colour::kMultiPointT);
  compensated.marker = plot::Marker::diamond;
  plot::Curve raw_holds = measured_curve(run.noise.holds.curve, "holds, raw", plot::colour::kThreePoint);
  raw_holds.hollow = true;
  panel.curves = {std::move(raw), std::move(compensated), std::move(raw_holds), fit_line(holds),
                  measured_curve(holds.curve, "holds, compensated", plot::colour::kTemperature)};
  panel.left.range = measured_range(panel.curves);
  bool named = false;
  for (const data::NoiseCoefficient& noise : holds.fit.coefficients) {
    if (!noise.seen) continue;
    panel.curves.push_back(term_line(noise, holds.curve));
    panel.curves.back().name = named ? "" : "noise terms";
    named = true;
  }
  return panel;
}

ReportFigure allan_figure(const Report& report) {
  const plot::Plot plot{.id = "allan",
                        .title = "Allan deviation of the holds and of the whole runs",
                        .x = {.title = "Averaging time τ, s", .logarithmic = true},
                        .panels = {allan_panel(report.rate, "(a) ramp"), allan_panel(report.random, "(b) random")},
                        .simulated = report.rig.is_virtual};
  return {plot.id,
          "Overlapping Allan deviation. Circles: last hour of the holds with standard errors; hollow: raw, filled: "
          "compensated by the multi-point model with temperature. Line: fit to the filled circles; dashed: its noise "
          "terms. Squares: cluster means of the whole run before compensation; diamonds: after compensation by the "
          "same model.",
          to_svg(plot)};
}

}  // namespace

std::vector<ReportFigure> all_figures(const Report& report) {
  std::vector<ReportFigure> all;
  if (auto thermal = thermal_figure(report)) all.push_back(std::move(*thermal));
  all.push_back(temperature_figure(report, report.rate, "figure-4"));
  all.push_back(correlation_array(report));
  all.push_back(correlation_curves(report));
  for (ReportFigure& figure : rate_figures(report)) all.push_back(std::move(figure));
  all.push_back(allan_figure(report));
  all.push_back(temperature_figure(report, report.random, "figure-8-program"));
  all.push_back(random_figure(report));
  all.push_back(tuning_figure(report));
  return all;
}

}  // namespace gyrotherm::report
