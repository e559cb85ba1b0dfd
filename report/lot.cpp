// SPDX-License-Identifier: Apache-2.0
#include "report/lot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/json.hpp"
#include "report/html_page.hpp"
#include "report/plot/plot.hpp"
#include "report/plot/svg.hpp"
#include "report/views.hpp"

namespace gyrotherm::report {

namespace {

std::string axis_label(const LotAxis& axis) { return axis.axis.empty() ? axis.unit : axis.unit + "." + axis.axis; }

double median_of_sorted(const std::vector<double>& sorted) {
  const auto half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return median_of_sorted(values);
}

}  // namespace

void describe(auto& form, Like<LotAxis> auto& axis) {
  form("unit", axis.unit);
  form("axis", axis.axis);
  form("serial_number", axis.serial_number);
  form("model", axis.model);
  form("folder", axis.folder);
  form("verdict", axis.verdict);
  form("trouble", axis.trouble);
  form("raw_std_deg_per_h", axis.raw_std_deg_per_h);
  form("compensated_std_deg_per_h", axis.compensated_std_deg_per_h);
  form("compensated_rmse_deg_per_h", axis.compensated_rmse_deg_per_h);
  form("noise_floor_deg_per_h", axis.floor_deg_per_h);
  form("expanded_uncertainty_deg_per_h", axis.expanded_deg_per_h);
  form("missing_s", axis.missing_s);
  form("raw_score", axis.raw_score);
  form("compensated_score", axis.compensated_score);
  form("stands_out", axis.is_outlier);
}

void describe(auto& form, Like<Lot> auto& lot) {
  form.derived("schema", kLotSchema);
  form("rig", lot.rig_name);
  form("title", lot.rig_title);
  form.if_present("order_number", !lot.order_number.empty(), lot.order_number);
  form("simulated", lot.simulated);
  form("program_version", lot.program_version);
  form("seed", lot.seed);
  form("quick", lot.quick);
  const auto verdict = overall_verdict(lot);
  form.derived("verdict", verdict.c_str());
  form("axes", lot.axes);
  form("events", lot.events);
}

void copy_results(const Report& report, LotAxis& axis) {
  axis.verdict = overall_verdict(report);
  axis.raw_std_deg_per_h = report.random.raw.std;
  const auto& left = report.random.residual.multi_point_t.all;
  axis.compensated_std_deg_per_h = left.std;
  axis.compensated_rmse_deg_per_h = left.rmse;
  axis.floor_deg_per_h = report.random.floor.deg_per_h;
  if (const auto& uncertainty = report.models.multi_point_t.uncertainty)
    axis.expanded_deg_per_h = combined(uncertainty->budget.rows).expanded_deg_per_h;
}

constexpr std::size_t kFewestScored = 6;

/// Returns the reason why the lot has no scores; empty if it has them or does not need the reason.
std::string missing_scores_reason(const Lot& lot) {
  const auto lacks_all = [&](double LotAxis::*score) {
    return std::ranges::all_of(lot.axes, [&](const LotAxis& axis) { return std::isnan(axis.*score); });
  };
  if (lot.axes.empty() || !lacks_all(&LotAxis::raw_score) || !lacks_all(&LotAxis::compensated_score)) return {};
  return lot.axes.size() < kFewestScored
             ? fmt::format("no score: at least {} axes are needed", kFewestScored)
             : fmt::format("no score: fewer than {} axes have a result, or half of the results are equal",
                           kFewestScored);
}

std::vector<double> robust_scores(const std::vector<double>& values) {
  // MAD of a normal distribution divided by its standard deviation.
  constexpr double kMadOfNormal = 0.6745;
  std::vector<double> scores(values.size(), kNotKnown), known;
  for (const double value : values)
    if (value > 0) known.push_back(std::log(value));
  if (known.size() < kFewestScored) return scores;
  const double middle = median(known);
  for (double& one : known) one = std::abs(one - middle);
  const double deviation = median(known);
  if (deviation == 0) return scores;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] > 0) scores[i] = kMadOfNormal * (std::log(values[i]) - middle) / deviation;
  return scores;
}

void compare(Lot& lot) {
  const auto column = [&](double LotAxis::*figure) {
    std::vector<double> values;
    for (const auto& axis : lot.axes) values.push_back(axis.*figure);
    return robust_scores(values);
  };
  const auto raw = column(&LotAxis::raw_std_deg_per_h), compensated = column(&LotAxis::compensated_std_deg_per_h);
  for (std::size_t i = 0; i < lot.axes.size(); ++i) {
    auto& axis = lot.axes[i];
    axis.raw_score = raw[i];
    axis.compensated_score = compensated[i];
    axis.is_outlier = std::abs(raw[i]) > kOutlierScore || std::abs(compensated[i]) > kOutlierScore;
  }
}

std::string overall_verdict(const Lot& lot) {
  const auto any = [&](const char* verdict) {
    return std::ranges::any_of(lot.axes, [&](const auto& axis) { return axis.verdict == verdict; });
  };
  if (any("FAIL") || any("failed")) return "FAIL";
  return any("PASS") ? "PASS" : "no limit";
}

std::string to_json(const Lot& lot) { return json_text(make_json(lot), 1) + "\n"; }

namespace {

std::string number(double value) { return std::isnan(value) ? "–" : fmt::format("{:.5f}", value); }
/// Formats a score with its sign and the minus sign of typography. Zero has no sign.
std::string format_score(double value) {
  if (std::isnan(value)) return "–";
  const auto text = fmt::format("{:.2f}", std::abs(value));
  if (text == "0.00") return text;
  return (value < 0 ? "−" : "+") + text;
}

std::string make_remark(const LotAxis& axis) {
  std::string remark = axis.trouble;
  const auto add = [&](const std::string& more) { remark += (remark.empty() ? "" : "; ") + more; };
  if (axis.is_outlier) add("outlier");
  if (axis.missing_s > 0) add(fmt::format("no reading for {:.0f} s", axis.missing_s));
  return remark;
}

/// Returns the rows of the table without its header.
std::vector<std::vector<std::string>> lot_rows(const Lot& lot, const std::string& only_unit) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& axis : lot.axes)
    if (only_unit.empty() || axis.unit == only_unit)
      rows.push_back({axis_label(axis), axis.serial_number, axis.verdict, make_remark(axis),
                      number(axis.raw_std_deg_per_h), number(axis.compensated_std_deg_per_h),
                      number(axis.floor_deg_per_h), number(axis.expanded_deg_per_h), format_score(axis.raw_score),
                      format_score(axis.compensated_score)});
  return rows;
}

HtmlTable lot_table(const Lot& lot, const std::string& only_unit = {}) {
  HtmlTable table{.caption =
                      "Random run, not used to train any model, °/h: standard deviation of the bias before and after "
                      "compensation by multi-point with temperature; noise floor; U (k as in the budget) of a mean "
                      "over 1 h; robust scores of both deviations within the lot",
                  .header = {"axis", "serial number", "verdict", "remark", "raw", "compensated", "floor", "U",
                             "score raw", "score comp."},
                  .text_columns = 4,
                  .style = "small"};
  for (auto& row : lot_rows(lot, only_unit)) {
    for (auto& cell : row) cell = plot::escaped(cell);
    table.rows.push_back(std::move(row));
  }
  return table;
}

plot::Curve value_curve(const Lot& lot, const char* name, const char* colour, double LotAxis::*figure, bool hollow) {
  plot::Curve curve{.name = name, .colour = colour, .marker = plot::Marker::circle, .hollow = hollow, .line = false};
  for (std::size_t i = 0; i < lot.axes.size(); ++i) {
    curve.x.push_back(static_cast<double>(i));
    curve.y.push_back(lot.axes[i].*figure);
  }
  return curve;
}

std::string lot_figure(const Lot& lot) {
  plot::Plot plot{
      .id = "lot", .title = "Bias of every axis before and after compensation", .x = {}, .simulated = lot.simulated};
  for (const auto& axis : lot.axes) plot.x.categories.push_back(axis_label(axis));
  plot::Panel panel;
  panel.left = {.title = "°/h", .logarithmic = true};
  panel.curves = {
      value_curve(lot, "raw", plot::colour::kRaw, &LotAxis::raw_std_deg_per_h, false),
      value_curve(lot, "compensated", plot::colour::kMultiPointT, &LotAxis::compensated_std_deg_per_h, false),
      value_curve(lot, "noise floor", plot::colour::kBias, &LotAxis::floor_deg_per_h, true)};
  plot.panels.push_back(std::move(panel));
  return fmt::format(
      "<figure tabindex=\"0\">\n{}<figcaption><b>Figure</b> Standard deviation of the bias in the random run, not used "
      "to train any "
      "model, and the noise floor of its holds.</figcaption>\n</figure>\n",
      to_svg(plot));
}

std::string events_html(const Lot& lot) {
  std::string html = "<ul class=\"warnings\">\n";
  for (const auto& event : lot.events) html += "<li>" + plot::escaped(event) + "</li>\n";
  return html + "</ul>\n";
}

/// Prefixes all ids and references of an axis' page with the axis, which makes them unique on the page of the unit.
std::string prefix_ids(std::string html, const std::string& axis) {
  for (const std::string before : {" id=\"", "url(#", "href=\"#"}) {
    for (auto at = html.find(before); at != std::string::npos; at = html.find(before, at + before.size()))
      html.insert(at + before.size(), axis + "-");
  }
  return html;
}

/// Describes the rig and the order of the lot.
std::string describe_source(const Lot& lot) {
  return lot.rig_title + (lot.order_number.empty() ? "" : ", order " + lot.order_number);
}

std::string heading(const std::string& text) { return "<h2>" + plot::escaped(text) + "</h2>\n"; }

/// Returns a link to the report of each unit.
std::string report_links(const Lot& lot) {
  std::string html = "<p>Reports:";
  std::string last;
  for (const auto& axis : lot.axes) {
    if (axis.unit == last) continue;
    last = axis.unit;
    html += fmt::format(" <a href=\"{0}/report/report.html\">{0}</a>", plot::escaped(axis.unit));
  }
  return html + "</p>\n";
}

}  // namespace

std::string describe(const Lot& lot) {
  auto text = std::string(lot.simulated ? "SIMULATED\n" : "");
  const auto line = [](const std::vector<std::string>& row) {
    return fmt::format("{:<12} {:<12} {:<9} {:>9} {:>12} {:>9} {:>9} {:>8} {:>8}  {}\n", row[0], row[1], row[2], row[4],
                       row[5], row[6], row[7], row[8], row[9], row[3]);
  };
  text += line({"axis", "serial", "verdict", "", "raw", "compensated", "floor", "U", "raw z", "comp. z"});
  for (const auto& row : lot_rows(lot, "")) text += line(row);
  text +=
      "STD of the bias in the random run, °/h, raw and compensated; U of a mean over 1 h; z: robust score in the lot\n";
  if (const auto reason = missing_scores_reason(lot); !reason.empty()) text += reason + "\n";
  for (const auto& event : lot.events) text += "  " + event + "\n";
  return text;
}

std::string to_html(const Lot& lot) {
  auto body = fmt::format("<p>{} axes of one rig, in one chamber, with the same two profiles.{}</p>\n", lot.axes.size(),
                          lot.quick ? " Models were tuned with a small swarm, for a trial." : "");
  body += report_links(lot) + to_html(lot_table(lot)) + lot_figure(lot);
  body +=
      "<p>An axis is an outlier if its score is outside ±3.5 (Iglewicz and Hoaglin 1993). The score is 0.6745 times "
      "the "
      "distance of the logarithm of its deviation from the median of the lot, divided by the median of all such "
      "distances.</p>\n";
  if (const auto reason = missing_scores_reason(lot); !reason.empty()) body += fmt::format("<p>{}.</p>\n", reason);
  if (!lot.events.empty()) body += heading("Units that stopped sending or were dropped") + events_html(lot);
  return to_html(HtmlPage{.title = "Lot summary – " + lot.rig_title,
                          .kind = "Lot summary",
                          .heading = "Temperature compensation of a lot of gyros",
                          .subtitle = describe_source(lot),
                          .simulated = lot.simulated,
                          .body = body,
                          .footer = "gyrotherm " + lot.program_version});
}

std::string unit_to_html(const Lot& lot, const std::string& unit,
                         const std::vector<std::pair<std::string, Report>>& axes) {
  auto body = to_html(lot_table(lot, unit));
  for (const auto& [axis, report] : axes)
    body += fmt::format("<h1 id=\"axis-{0}\">Axis {0}</h1>\n", plot::escaped(axis)) +
            prefix_ids(body_html(report, all_figures(report)), axis);
  const auto found = std::ranges::find(lot.axes, unit, &LotAxis::unit);
  const auto serial = found == lot.axes.end() || found->serial_number.empty() ? "" : ", " + found->serial_number;
  return to_html(HtmlPage{
      .title = fmt::format("Qualification report – {}{}", unit, serial),
      .kind = "Qualification report",
      .heading = "Temperature compensation of gyro bias",
      .subtitle = fmt::format("{}{} – {}", unit, serial, describe_source(lot)),
      .simulated = lot.simulated,
      .body = body,
      .footer = fmt::format("gyrotherm {} · generated from the report.json of each axis", lot.program_version)});
}

}  // namespace gyrotherm::report
