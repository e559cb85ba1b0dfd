// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "report/html_page.hpp"
#include "report/plot/svg.hpp"
#include "report/views.hpp"

namespace gyrotherm::report {
namespace {

constexpr std::array<std::pair<const char*, const char*>, 13> kThermalNames{
    {{"zerodur", "Zerodur glass ceramic"},
     {"gain_gas", "Gas in the gain arms"},
     {"passive_bore", "Gas in the passive bores"},
     {"ballast", "Ballast resistors"},
     {"preamplifier", "Preamplifier circuit"},
     {"cathode", "Cathode"},
     {"dither", "Dither mechanism"},
     {"hub", "Hub"},
     {"cabinet", "Cabinet"},
     {"air", "Air in the cabinet"},
     {"source.gain_area", "Gain area, both arms"},
     {"source.preamplifier", "Preamplifier circuit"},
     {"source.ballast", "Ballast resistor, each of two"}}};

std::string thermal_name(const std::string& key, const std::string& fallback) {
  const auto found = std::ranges::find_if(kThermalNames, [&](const auto& one) { return key == one.first; });
  return plot::escaped(found == kThermalNames.end() ? fallback : found->second);
}

/// Formats a value with at most four significant digits, without trailing zeros and without an exponent.
std::string format_four_digits(double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "–"; }

std::string simulated_mark(const Report& report) { return report.rig.is_virtual ? " – <b>SIMULATED</b>" : ""; }

std::string materials_table(const Report& report, const ReportedThermalModel& model) {
  HtmlTable table{.caption = "Thermal parameters of the gyro’s materials" + simulated_mark(report),
                  .header = {"Material", "Density, kg/m³", "Specific heat, J/(kg·K)", "Conductivity, W/(m·K)"}};
  for (const ReportedMaterial& one : model.materials)
    table.rows.push_back({thermal_name(one.name, one.name), format_four_digits(one.density_kg_per_m3),
                          format_four_digits(one.specific_heat_j_per_kg_k),
                          format_four_digits(one.conductivity_w_per_m_k)});
  return to_html(table);
}

std::string heat_sources_table(const Report& report, const ReportedThermalModel& model) {
  HtmlTable table{.caption = "Heat sources of the gyro" + simulated_mark(report),
                  .header = {"Heat source", "Power, W", "Volume, 10<sup>−6</sup>&nbsp;m³",
                             "Heat generation rate, 10<sup>4</sup>&nbsp;W/m³"}};
  for (const ReportedHeatSource& one : model.sources)
    table.rows.push_back({thermal_name("source." + one.name, one.name), format_four_digits(one.power_w),
                          format_four_digits(1e6 * one.volume_m3), format_four_digits(1e-4 * one.rate_w_per_m3)});
  return to_html(table);
}

std::string model_note(const ReportedThermalModel& model) {
  return fmt::format(
      "<p class=\"note\">Both tables are from the gyro file <code>{}</code> ({}). Its comments name the values from "
      "the paper and the assumed values. A virtual gyro drawn with a seed differs from the file by the spread in the "
      "rig file. The conductivity of air depends on the gap because of natural convection and radiation. The row of "
      "the ballast resistors in the paper is inconsistent; this report uses “{}”.</p>\n",
      plot::escaped(model.gyro), plot::escaped(model.title), plot::escaped(model.ballast_reading));
}

/// Returns a table of the paper's three items with the reason why each is missing.
std::string missing_items(const ReportedThermal& thermal) {
  HtmlTable table{.caption = "Items of the paper that this report does not contain",
                  .header = {"Item of the paper", "Content", "Reason"},
                  .text_columns = 3,
                  .style = "small"};
  for (const auto& [item, content] : {std::pair{"Table 1", "Thermal parameters of the gyro’s materials"},
                                      {"Table 2", "Heat sources of the gyro"},
                                      {"Figure 1", "Thermal image of the working gyro"}})
    table.rows.push_back(
        {item, content, fmt::format("{}: {}", plot::escaped(thermal.missing), plot::escaped(thermal.reason))});
  return to_html(table);
}

}  // namespace

std::string thermal_html(const Report& report) {
  const auto& model = report.thermal.model;
  if (!model) return missing_items(report.thermal);
  return materials_table(report, *model) + heat_sources_table(report, *model) + model_note(*model);
}

std::optional<ReportFigure> thermal_figure(const Report& report) {
  if (!report.thermal.model) return std::nullopt;
  const ReportedThermalImage& image = report.thermal.model->image;
  plot::ThermalImage view = image.view;
  view.simulated = report.rig.is_virtual;
  return ReportFigure{
      "figure-1",
      fmt::format("Thermal image of the working gyro{}: the top face of its block at steady state, on the {} mesh of "
                  "the finite-element model ({} elements, {} nodes), in still air of {} °C "
                  "(film {} W/(m²·K)). The gain areas A, B, C are {} K warmer than F, G, H.",
                  report.rig.is_virtual ? ", SIMULATED" : "", image.mesh, image.elements, image.nodes,
                  format_four_digits(image.ambient_c), format_four_digits(image.film_w_per_m2_k),
                  plot::decimal(image.difference_k, 2)),
      to_svg(view)};
}

}  // namespace gyrotherm::report
