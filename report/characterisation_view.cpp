// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "report/plot/svg.hpp"
#include "report/views.hpp"

namespace gyrotherm::report {
namespace {

using model::BeforeAfter;
using model::Characterisation;
using model::MeasuredValue;

std::string cell(const MeasuredValue& measured) {
  return std::isfinite(measured.value) ? plot::format_with_error(measured.value, measured.u) : "–";
}

/// Returns a table row: name, unit or temperature, value before and after compensation.
std::string row(const std::string& name, const std::string& about, const BeforeAfter& figures) {
  return fmt::format("<tr><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n", name, about,
                     cell(figures.before), cell(figures.after));
}

std::string table(const std::string& caption, const std::string& first, const std::string& second,
                  const std::string& rows) {
  return fmt::format(
      "<table class=\"small\" "
      "tabindex=\"0\">\n<caption><span>{}</span></caption>\n<thead><tr><th>{}</th><th>{}</th><th "
      "class=\"n\">Before</th>"
      "<th class=\"n\">After</th></tr></thead>\n<tbody>\n{}</tbody>\n</table>\n",
      caption, first, second, rows);
}

std::string celsius(double temperature_c, int decimals) { return plot::decimal(temperature_c, decimals) + "&nbsp;°C"; }

/// Returns the hysteresis at its widest point, separately before and after compensation.
std::string hysteresis_row(const Characterisation& result) {
  BeforeAfter figures;
  std::string places;
  for (const auto which : {&BeforeAfter::before, &BeforeAfter::after}) {
    const model::HysteresisPoint* point = find_widest(result.hysteresis, which);
    if (point == nullptr) continue;
    figures.*which = point->width.*which;
    places += (places.empty() ? "" : " and ") + celsius(point->temperature_c, 0);
  }
  return row("Largest hysteresis, heating minus cooling", "°/h, near " + (places.empty() ? "–" : places), figures);
}

std::string retrace_row(const Characterisation& result) {
  const model::Retrace* greatest = nullptr;
  for (const model::Retrace& retrace : result.retrace) {
    if (greatest == nullptr || std::abs(retrace.change.before.value) > std::abs(greatest->change.before.value))
      greatest = &retrace;
  }
  if (greatest == nullptr) return row("Retrace", "°/h", {});
  return row(fmt::format("Retrace at {}, the largest of {}", celsius(greatest->set_point_c, 0), result.retrace.size()),
             "°/h", greatest->change);
}

std::string coefficients_table(const Characterisation& result, const std::string& caption) {
  const std::string gradient = result.gradient.empty() ? "–" : plot::escaped(result.gradient);
  return table(caption, "Parameter", "Unit",
               row("Temperature, linear fit to the hold biases", "°/h/K", result.temperature) +
                   row("Temperature ramp", "°/h/(K/min)", result.ramp) +
                   row("Gradient " + gradient, "°/h/K", result.of_gradient) + hysteresis_row(result) +
                   retrace_row(result));
}

std::string stabilised_table(const Characterisation& result) {
  std::string rows;
  for (const model::StabilisedBias& point : result.stabilised)
    rows += row(celsius(point.set_point_c, 1), celsius(point.temperature_c, 2), point.bias);
  return table("Hold bias at each temperature, °/h", "Set point", "Block", rows);
}

std::string minutes(const MeasuredValue& seconds) {
  return std::isfinite(seconds.value) ? plot::decimal(seconds.value / 60, 0) + "&nbsp;min" : "not within this hold";
}

std::string two_position_table(const Characterisation& result) {
  std::string rows;
  for (const model::TwoPosition& found : result.two_position) {
    const std::string at = " at " + celsius(found.set_point_c, 0);
    const bool is_stated = std::isfinite(found.stated_earth_rate_deg_per_h);
    rows += row("Bias" + at, "°/h", found.bias) +
            row("Earth rate on the axis" + at +
                    (is_stated ? fmt::format(", by the rig file {:.5f} °/h", found.stated_earth_rate_deg_per_h) : ""),
                "°/h", found.earth_rate);
  }
  return table("Bias and Earth rate, separated by turning the gyro around", "Parameter", "Unit", rows);
}

std::string warm_up_note(const model::WarmUp& found) {
  return fmt::format(
      "<p>Warm-up at {}, if the gyro was switched on {}: {} before compensation (to within {}&nbsp;°/h of the hold’s "
      "final bias), {} after.</p>\n",
      celsius(found.set_point_c, 0), describe_switch_on(found), minutes(found.seconds.before),
      plot::format_bias(found.within.before.value), minutes(found.seconds.after));
}

}  // namespace

std::string characterisation_html(const Report& report) {
  const ReportedRun& run = report.rate;
  const Characterisation& result = run.characterisation;
  std::string html = coefficients_table(
      result, fmt::format("Bias in the {} run before and after compensation by multi-point with temperature; ± is the "
                          "standard uncertainty due to the noise of this record alone",
                          plot::escaped(run.profile)));
  if (!result.stabilised.empty()) html += stabilised_table(result);
  if (!result.two_position.empty()) html += two_position_table(result);
  for (const model::WarmUp& found : result.warm_ups) html += warm_up_note(found);
  return html + fmt::format(
                    "<p class=\"note\">Hold bias: {}. Ramp and gradient are each fitted together with a linear term in "
                    "the temperature. They are not independent of each other: a ramp causes a gradient. Hysteresis "
                    "before compensation includes the effect of the ramp.{}</p>\n",
                    plot::escaped(result.statement),
                    run.in_sample ? " After compensation the results are in-sample." : "");
}

}  // namespace gyrotherm::report
