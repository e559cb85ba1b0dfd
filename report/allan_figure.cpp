#include "report/allan_figure.hpp"

#include <cmath>
#include <utility>

#include "core/quantity.hpp"
#include "plot/plot.hpp"
#include "plot/svg.hpp"

namespace gyrotherm {
namespace {

Curve curve_of(const AllanCurveView& points, const char* name, const char* colour) {
  Curve curve{.name = name, .colour = colour};
  for (const AllanPointView& point : points) {
    curve.x.push_back(point.tau_s);
    curve.y.push_back(point.deviation_deg_per_h);
  }
  return curve;
}

/// Markers and error bars, without a line between them.
Curve measured(const AllanCurveView& points, const char* name, const char* colour) {
  Curve curve = curve_of(points, name, colour);
  for (const AllanPointView& point : points) curve.error.push_back(point.error_deg_per_h);
  curve.marker = Marker::circle;
  curve.line = false;
  return curve;
}

/// A term alone: what power of τ its σ goes with, and where σ is known.
struct TermLine {
  const char* symbol;
  double power;
};
constexpr TermLine kTermLines[] = {{"Q", -1}, {"N", -0.5}, {"B", 0}, {"K", 0.5}, {"R", 1}};

/// σ of one term over the span of the points: its coefficient at its read-off time (Q in arcsec is °/h times seconds).
Curve term_line(const NoiseView& noise, const AllanCurveView& points) {
  constexpr double kFlat = 0.66428;
  Curve line{.name = {}, .colour = colour::kFaintInk, .dashed = true};
  for (const TermLine& term : kTermLines) {
    if (noise.symbol != term.symbol) continue;
    const double in_degrees = noise.symbol == "Q" ? noise.value / kSecondsPerHour : noise.value;
    for (const AllanPointView& point : points) {
      line.x.push_back(point.tau_s);
      line.y.push_back(term.power == 0 ? kFlat * noise.value
                                       : in_degrees * std::pow(point.tau_s / noise.read_off_s, term.power));
    }
  }
  return line;
}

Curve fit_line(const HoldNoiseView& holds) {
  Curve line = curve_of(holds.curve, "fit", colour::kInk);
  line.y = holds.fitted_deg_per_h;
  line.width_px = 1.4;
  return line;
}

/// All but the lines of single terms, which may leave the panel.
Range range_of_points(const std::vector<Curve>& curves) {
  std::vector<double> ends;
  for (const Curve& curve : curves) {
    for (std::size_t k = 0; k < curve.y.size(); ++k) {
      const double error = curve.error.empty() ? 0 : curve.error[k];
      ends.insert(ends.end(), {curve.y[k], curve.y[k] + error});
    }
  }
  return logarithmically_rounded_out(positive_range_of(ends));
}

Panel panel_of(const RunView& run, const std::string& title) {
  Panel panel;
  panel.title = title;
  panel.left = {.title = "Allan deviation, °/h", .logarithmic = true};
  panel.height_px = 210;
  const HoldNoiseView& holds = run.allan.compensated_holds;
  Curve raw = curve_of(run.allan.raw, "run, raw", colour::kRaw);
  raw.marker = Marker::square;
  raw.hollow = true;
  Curve compensated = curve_of(run.allan.compensated.multi_point_t, "run, compensated", colour::kMultiPointT);
  compensated.marker = Marker::diamond;
  Curve raw_holds = measured(run.allan.holds.curve, "holds, raw", colour::kThreePoint);
  raw_holds.hollow = true;
  panel.curves = {std::move(raw), std::move(compensated), std::move(raw_holds), fit_line(holds),
                  measured(holds.curve, "holds, compensated", colour::kTemperature)};
  panel.left.range = range_of_points(panel.curves);
  bool named = false;
  for (const NoiseView& noise : holds.coefficients) {
    if (!noise.seen) continue;
    panel.curves.push_back(term_line(noise, holds.curve));
    panel.curves.back().name = named ? "" : "its terms";
    named = true;
  }
  return panel;
}

}  // namespace

ReportFigure allan_figure(const ReportView& view) {
  const Plot plot{.id = "allan",
                  .title = "Allan deviation of the holds and of the whole runs",
                  .x = {.title = "Averaging time τ, s", .logarithmic = true},
                  .panels = {panel_of(view.rate, "(a) rate"), panel_of(view.random, "(b) random")},
                  .simulated = view.simulated};
  return {
      plot.id, "Allan deviation",
      "Overlapping Allan deviation. Circles: the last hour of the holds with standard errors, hollow raw, full after "
      "compensation by the multi-point model with temperature; line: the fit to the latter, dashed its terms one by "
      "one. Squares: cluster means of the whole run before compensation; diamonds: after it, by the same model.",
      svg_of(plot)};
}

}  // namespace gyrotherm
