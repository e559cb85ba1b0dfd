// SPDX-License-Identifier: Apache-2.0
#include "report/fusion_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "core/file.hpp"
#include "core/quantity.hpp"
#include "report/html_page.hpp"
#include "report/plot/plot.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kMean_s = 100;
constexpr std::array kComponents = {"x", "y", "z"};

std::vector<double> to_vector(const Eigen::VectorXd& column) { return {column.begin(), column.end()}; }

std::vector<double> to_hours(const Eigen::VectorXd& seconds) { return to_vector(seconds / kSecondsPerHour); }

plot::Plot make_hour_plot(const model::FusionSummary& summary, const char* id, const char* title) {
  return {
      .id = id, .title = title, .x = {.title = "Time since the start of the run, h"}, .simulated = summary.simulated};
}

std::string figure(const plot::Plot& plot, const std::string& caption) {
  return fmt::format("<figure id=\"{}\" tabindex=\"0\">\n{}<figcaption>{}</figcaption>\n</figure>\n", plot.id,
                     to_svg(plot), caption);
}

/// Returns a figure of the mean rate, minus the Earth rate if it is known.
std::string rate_figure(const model::FusedRun& run) {
  const bool is_error = !run.summary.earth_deg_per_h.empty();
  model::ClusterMeans means = model::cluster_means(run.time_s, run.rate_deg_per_h, kMean_s);
  plot::Plot plot = make_hour_plot(run.summary, "fused-rate", "The fused rate over time");
  for (std::size_t k = 0; k < kComponents.size(); ++k) {
    Eigen::VectorXd values = means.mean.col(static_cast<Eigen::Index>(k));
    if (is_error) values.array() -= run.summary.earth_deg_per_h[k];
    plot::Panel panel = plot::make_panel(fmt::format("({}) {}", static_cast<char>('a' + k), kComponents[k]),
                                         is_error ? "Error, °/h" : "Rate, °/h",
                                         {{.name = is_error ? "fused rate minus Earth rate" : "fused rate",
                                           .colour = plot::colour::kMultiPointT,
                                           .x = to_hours(means.end_s),
                                           .y = to_vector(values)}},
                                         130);
    plot.panels.push_back(std::move(panel));
  }
  return figure(plot, fmt::format("The fused rate in the axes of the fixture{}; means over {:.0f}&nbsp;s.",
                                  is_error ? ", minus the Earth rate in the recorded attitude" : "", kMean_s));
}

/// Returns a figure of the parity statistic: each second, and the mean of each cluster.
std::string parity_figure(const model::FusedRun& run) {
  if (!std::isfinite(run.summary.limit)) return {};
  const model::ClusterMeans means = model::cluster_means(run.time_s, run.statistic, kMean_s);
  plot::Plot plot = make_hour_plot(run.summary, "parity", "Parity of the axes over time");
  const auto degrees = run.summary.axes.size() - 3;
  plot::Panel panel = plot::make_panel(
      {}, "pᵀp",
      {{.name = "each second", .colour = plot::colour::kRaw, .x = to_hours(run.time_s), .y = to_vector(run.statistic)},
       {.name = fmt::format("mean over {:.0f} s", kMean_s),
        .colour = plot::colour::kMultiPoint,
        .x = to_hours(means.end_s),
        .y = to_vector(means.mean.col(0))}},
      200);
  panel.rules = {{"limit", run.summary.limit}};
  const double greatest = run.statistic.array().isFinite().select(run.statistic, 0).maxCoeff();
  panel.left.range = plot::Range{0, 1.1 * std::max(run.summary.limit, greatest)};
  plot.panels = {std::move(panel)};
  return figure(
      plot,
      fmt::format("Squared length of the parity vector, which has a χ² distribution with {} degree{} of freedom "
                  "without a fault, and the limit that it exceeds by chance with a probability of {} in each second.",
                  degrees, degrees == 1 ? "" : "s", plot::format_significant(run.summary.false_alarm_probability)));
}

/// Returns a figure with a line per axis while it contributes to the rate.
std::string axes_figure(const model::FusedRun& run) {
  plot::Plot plot = make_hour_plot(run.summary, "axes", "Axes used for the rate");
  plot::Panel panel = plot::make_panel({}, {}, {}, 24.0 * static_cast<double>(run.summary.axes.size()) + 30);
  for (std::size_t a = 0; a < run.summary.axes.size(); ++a) {
    panel.left.categories.push_back(run.summary.axes[a].name);
    plot::Curve curve{
        .name = run.summary.axes[a].name, .colour = plot::palette(a), .x = to_hours(run.time_s), .width_px = 5};
    for (const model::AxisSet used : run.used)
      curve.y.push_back((used >> a & 1) != 0 ? static_cast<double>(a) : std::numeric_limits<double>::quiet_NaN());
    panel.curves.push_back(std::move(curve));
  }
  plot.panels = {std::move(panel)};
  return figure(plot, "Axes used for the fused rate. A gap: the axis was excluded or had no value.");
}

std::string alarms_table(const model::FusionSummary& summary) {
  if (summary.alarms.empty()) return "<p>No fault was detected.</p>\n";
  HtmlTable table{.header = {"Detector", "Source", "Statement", "Reported at", "Since", "Until", "Size"},
                  .text_columns = 3,
                  .style = "small"};
  constexpr std::size_t kMaxListedAlarms = 60;
  for (const model::Alarm& alarm : summary.alarms) {
    if (table.rows.size() == kMaxListedAlarms) break;
    const bool is_thermometer = alarm.kind == model::AlarmKind::thermometer;
    table.rows.push_back(
        {name(alarm.kind), plot::escaped(alarm.who.empty() ? "–" : alarm.who),
         plot::escaped(with_minus_signs(alarm.statement)), plot::format_hours(alarm.at_s),
         plot::format_hours(alarm.since_s), plot::format_hours(alarm.until_s),
         alarm.who.empty() ? "–" : plot::decimal(alarm.size, 4) + (is_thermometer ? "&nbsp;K" : "&nbsp;°/h")});
  }
  const auto more = summary.alarms.size() - table.rows.size();
  return to_html(table) + (more > 0 ? fmt::format("<p class=\"note\">fusion.json contains {} more.</p>\n", more) : "");
}

std::string warnings_html(const model::FusionSummary& summary) {
  if (summary.warnings.empty()) return {};
  std::string html = "<ul class=\"warnings\">\n";
  for (const std::string& warning : summary.warnings) html += "<li>" + plot::escaped(warning) + "</li>\n";
  return html + "</ul>\n";
}

std::string axes_table(const model::FusionSummary& summary) {
  HtmlTable table{
      .header = {"Axis", "Model", "Direction", "u, 1 s", "u, 1 h", "RMS error", "Excluded, s", "Outside, s"},
      .text_columns = 3,
      .style = "small"};
  for (const model::FusedAxisSummary& axis : summary.axes)
    table.rows.push_back({plot::escaped(axis.name), plot::escaped(axis.method + " " + axis.inputs),
                          fmt::format("{}, {}, {}", plot::decimal(axis.direction[0], 4),
                                      plot::decimal(axis.direction[1], 4), plot::decimal(axis.direction[2], 4)),
                          plot::format_bias(axis.second_std_deg_per_h), plot::format_bias(axis.hour_std_deg_per_h),
                          plot::format_bias(axis.error_rms_deg_per_h), std::to_string(axis.left_out_s),
                          std::to_string(axis.outside_s)});
  return to_html(table) +
         "<p class=\"note\">u, °/h: standard uncertainty of one second, without the errors that training and use have "
         "in common, and of a mean over one hour, with them. RMS error: means over 100&nbsp;s minus the Earth rate on "
         "the axis.</p>\n";
}

std::string format_with_expanded(const std::vector<double>& values, const std::vector<double>& expanded,
                                 std::size_t k) {
  return plot::format_with_error(values[k], expanded[k]);
}

std::string heading_text(const model::RestStretch& rest) {
  if (!rest.heading_deg) return "–";
  return fmt::format("({})°", plot::format_with_error(*rest.heading_deg, *rest.heading_expanded_deg));
}

std::string rest_table(const model::FusionSummary& summary) {
  HtmlTable table{.caption = "Rate at rest ± U (k = 2), °/h, in the axes of the fixture; heading ± U (95&nbsp;%)",
                  .header = {"Stretch", "x", "y", "z", "Error", "Heading", "χ² (limit)"},
                  .style = "small"};
  const auto add = [&](const model::RestStretch& rest, const std::string& label) {
    double squares = 0;
    for (const double by : rest.residual_deg_per_h) squares += by * by;
    table.rows.push_back({label, format_with_expanded(rest.rate.deg_per_h, rest.rate.expanded_deg_per_h, 0),
                          format_with_expanded(rest.rate.deg_per_h, rest.rate.expanded_deg_per_h, 1),
                          format_with_expanded(rest.rate.deg_per_h, rest.rate.expanded_deg_per_h, 2),
                          plot::format_bias(std::sqrt(squares)), heading_text(rest),
                          fmt::format("{} ({})", plot::decimal(rest.statistic, 1), plot::decimal(rest.limit, 1))});
  };
  if (summary.rest) add(*summary.rest, "<b>all holds</b>");
  for (const model::RestStretch& rest : summary.holds)
    add(rest,
        fmt::format("{}&nbsp;·&nbsp;{}", plot::escaped(with_minus_signs(rest.name)), plot::format_hours(rest.start_s)));
  return to_html(table);
}

/// Returns a table of the axes' biases and the attitude of the fixture, estimated at standstill over all holds.
std::string bias_table(const model::RestStretch& rest) {
  if (rest.turn_deg.empty()) return {};
  HtmlTable table{.caption = "Biases and attitude estimated from the Earth rate over all holds",
                  .header = {"", "Estimate", "u"},
                  .style = "even"};
  for (std::size_t a = 0; a < rest.axes.size(); ++a)
    table.rows.push_back({"bias of " + plot::escaped(rest.axes[a]) + ", °/h", plot::decimal(rest.bias_deg_per_h[a], 5),
                          plot::decimal(rest.bias_std_deg_per_h[a], 5)});
  constexpr std::array kTurns = {"turn about north, °", "turn about east, °", "turn about down, °"};
  for (std::size_t k = 0; k < kTurns.size(); ++k)
    table.rows.push_back({kTurns[k], plot::decimal(rest.turn_deg[k], 4), plot::decimal(rest.turn_std_deg[k], 4)});
  return to_html(table);
}

std::string key_value_html(const std::string& label, const std::string& value, const char* unit,
                           const char* style = "") {
  return fmt::format(
      "<div class=\"key {}\"><span class=\"value\">{}</span><span class=\"unit\">{}</span>"
      "<span class=\"label\">{}</span></div>\n",
      style, value, unit, label);
}

std::string result_section(const model::FusionSummary& summary) {
  if (!summary.error || !summary.of_three) return {};
  std::string keys =
      key_value_html("error of the fused rate", plot::format_bias(summary.error->rms_deg_per_h), "°/h", "best");
  if (summary.axes.size() > 3) {
    keys += key_value_html("all axes, none excluded", plot::format_bias(summary.of_all_axes->rms_deg_per_h), "°/h") +
            key_value_html("only the first three axes", plot::format_bias(summary.of_three->rms_deg_per_h), "°/h") +
            key_value_html("inconsistent seconds", std::to_string(summary.contradictions), "");
  }
  if (summary.rest && summary.rest->heading_deg) {
    constexpr double kArcminutes = 60;
    const double difference = kArcminutes * (*summary.rest->heading_deg - *summary.said_heading_deg);
    const double expanded = kArcminutes * summary.rest->heading_expanded_deg.value_or(0);
    keys += key_value_html("heading minus stated heading, ± U (95 %)", plot::format_with_error(difference, expanded),
                           "arcmin");
  }
  return "<div class=\"keys\">\n" + keys + "</div>\n" +
         fmt::format(
             "<p class=\"note\">RMS length of the error of the rate vector, means over 100&nbsp;s, relative to the "
             "Earth rate in the recorded attitude{}.</p>\n",
             summary.simulated ? ", which is the true rate of the simulation" : "");
}

}  // namespace

std::string to_html(const model::FusedRun& run, const std::string& program_version) {
  const model::FusionSummary& summary = run.summary;
  std::string body;
  int sections = 0;
  const auto section = [&](const char* title) {
    body += fmt::format("<h2><span class=\"number\">{}</span>{}</h2>\n", ++sections, title);
  };
  if (const auto warnings = warnings_html(summary); !warnings.empty()) {
    section("Warnings");
    body += warnings;
  }
  if (const auto result = result_section(summary); !result.empty()) {
    section("Result");
    body += result;
  }
  section("Fused rate");
  body += rate_figure(run) + axes_table(summary);
  section("Parity and detections");
  body += parity_figure(run) + axes_figure(run) + alarms_table(summary);
  if (summary.rest) {
    section("At rest");
    body += rest_table(summary) + bias_table(*summary.rest);
  }
  return to_html(HtmlPage{.title = "Fusion of axes – " + summary.profile,
                          .kind = "Fusion of axes",
                          .heading = fmt::format("Rate vector of {} axes", summary.axes.size()),
                          .subtitle = fmt::format("{} · run {} · {} of {} seconds fused", summary.profile,
                                                  summary.run_id.substr(0, 12), summary.fused, summary.seconds),
                          .simulated = summary.simulated,
                          .body = body,
                          .footer = "gyrotherm " + program_version});
}

Result<void> write_fusion(const model::FusedRun& run, const std::string& folder, const std::string& program_version) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return failure(FaultKind::storage, folder, error.message());
  if (auto written = replace_text_file(folder + "/fusion.html", to_html(run, program_version)); !written)
    return written;
  return replace_text_file(folder + "/fusion.json", to_json(run.summary));
}

}  // namespace gyrotherm::report
