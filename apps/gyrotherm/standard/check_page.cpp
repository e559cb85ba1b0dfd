// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "apps/gyrotherm/standard/check_view.hpp"
#include "apps/gyrotherm/standard/check_words.hpp"
#include "report/document.hpp"
#include "report/plot/plot.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::app {
namespace {

/// Returns the label of a plateau with a true minus sign.
std::string shown(const std::string& plateau) { return plateau.starts_with('-') ? "−" + plateau.substr(1) : plateau; }

using assurance::Chart;
using assurance::CheckKind;
using report::Cell;

constexpr const char *kBlue = "#0072b2", *kGrey = "#6b7785", *kRed = "#c8401b";
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kPanelHeight = 120;

/// Draws the control charts of one history.
class ChartFigure {
 public:
  ChartFigure(const CheckedStandard& standard, report::Language language)
      : assessment_(standard.assessment), simulated_(standard.history.head.simulated), language_(language) {
    for (std::size_t r = 0; r < standard.history.checks.size(); ++r) runs_.push_back(static_cast<double>(r + 1));
    title_ =
        check_sentence(language, "charts_of", fmt::format("{}", fmt::join(standard.history.head.serial_numbers, ", ")));
  }

  [[nodiscard]] std::string svg() && {
    for (const std::string& axis : list_axes(false)) {
      for (const Chart& chart : assessment_.charts)
        if (chart.of.kind != CheckKind::thermometer && chart.of.axis == axis) add_individuals(chart);
      add_ewma(axis);
    }
    for (const std::string& unit : list_axes(true)) {
      add_thermometers(unit);
      add_ewma_of_thermometers(unit);
    }
    return plot::to_svg({.id = "control-charts",
                         .title = title_,
                         .x = {.title = word("run"), .range = plot::Range{0, runs_.back() + 1}},
                         .panels = std::move(panels_),
                         .simulated = simulated_,
                         .language = {.decimal_comma = language_ == report::Language::german,
                                      .simulated = std::string(report::translate(language_, "mark.simulated"))}});
  }

 private:
  [[nodiscard]] std::string word(std::string_view key) const { return std::string(check_word(language_, key)); }

  [[nodiscard]] std::string numbered(const std::string& title) const {
    return fmt::format("({}) {}", panels_.size() + 1, title);
  }

  template <class Value>
  [[nodiscard]] plot::Curve curve(const Chart& chart, Value value, const std::string& name, const char* colour) const {
    plot::Curve made{.name = name, .colour = colour, .x = runs_};
    for (const auto& point : chart.points) made.y.push_back(value(point));
    return made;
  }

  void add_individuals(const Chart& chart) {
    const bool is_first = panels_.empty();
    const auto named = [&](const char* key) { return is_first ? word(key) : std::string(); };
    auto values = curve(
        chart, [](const auto& point) { return point.value; }, named("value"), kBlue);
    values.marker = plot::Marker::circle;
    auto mean = curve(
        chart, [](const auto& point) { return point.centre; }, named("mean"), kGrey);
    auto low = curve(
        chart, [](const auto& point) { return point.low; }, named("limit"), kGrey);
    auto high = curve(
        chart, [](const auto& point) { return point.high; }, "", kGrey);
    low.dashed = high.dashed = true;
    auto out = curve(
        chart, [](const auto& point) { return point.is_out() ? point.value : kUnknown; }, named("out"), kRed);
    out.marker = plot::Marker::square;
    out.line = false;
    auto title = chart.of.axis + ": " + word("kind." + name(chart.of.kind));
    if (!chart.of.plateau.empty()) title += ", " + shown(chart.of.plateau);
    auto panel = plot::make_panel(numbered(title), chart.of.unit,
                                  {std::move(mean), std::move(low), std::move(high), std::move(values), std::move(out)},
                                  kPanelHeight);
    panel.left.range = range_of(chart);
    panels_.push_back(std::move(panel));
  }

  /// Returns the range of the values and of the limits of the last two thirds: the first limits are very wide.
  static plot::Range range_of(const Chart& chart) {
    std::vector<double> shown;
    for (std::size_t r = 0; r < chart.points.size(); ++r) {
      shown.push_back(chart.points[r].value);
      if (3 * r < chart.points.size()) continue;
      shown.push_back(chart.points[r].low);
      shown.push_back(chart.points[r].high);
    }
    return plot::round_out(plot::value_range(shown), 4);
  }

  /// Lists the axes, or the units with thermometers, in order.
  [[nodiscard]] std::vector<std::string> list_axes(bool of_thermometers) const {
    std::vector<std::string> axes;
    for (const Chart& chart : assessment_.charts)
      if ((chart.of.kind == CheckKind::thermometer) == of_thermometers && std::ranges::count(axes, chart.of.axis) == 0)
        axes.push_back(chart.of.axis);
    return axes;
  }

  void add_line(std::vector<plot::Curve>& curves, plot::Curve line) const {
    line.colour = plot::palette(curves.size());
    line.dashed = curves.size() >= plot::kPaletteSize;
    curves.push_back(std::move(line));
  }

  void add_panel(const std::string& title, const std::string& y, std::vector<plot::Curve> curves, double limit) {
    auto panel = plot::make_panel(numbered(title), y, std::move(curves), 1.3 * kPanelHeight);
    plot::Range range{-1.2 * limit, 1.2 * limit};
    for (const auto& one : panel.curves) range = plot::join_ranges(range, plot::value_range(one.y));
    panel.left.range = plot::round_out(range, 4);
    panel.rules = {{"", limit}, {"", -limit}};
    panels_.push_back(std::move(panel));
  }

  void add_ewma(const std::string& axis) {
    std::vector<plot::Curve> curves;
    for (const Chart& chart : assessment_.charts) {
      if (chart.of.kind == CheckKind::thermometer || chart.of.axis != axis) continue;
      const auto label =
          chart.of.kind == CheckKind::bias ? shown(chart.of.plateau) : word("short." + name(chart.of.kind));
      add_line(curves, curve(
                           chart, [](const auto& point) { return point.ewma; }, label, ""));
    }
    add_panel(check_sentence(language_, "ewma", axis), word("of_limit"), std::move(curves), 1);
  }

  void add_thermometers(const std::string& unit) {
    std::vector<std::string> plateaus;
    for (const Chart& chart : assessment_.charts)
      if (chart.of.kind == CheckKind::thermometer && chart.of.axis == unit &&
          std::ranges::count(plateaus, chart.of.plateau) == 0)
        plateaus.push_back(chart.of.plateau);
    for (const std::string& plateau : plateaus) {
      std::vector<plot::Curve> curves;
      for (const Chart& chart : assessment_.charts)
        if (chart.of.kind == CheckKind::thermometer && chart.of.axis == unit && chart.of.plateau == plateau)
          add_line(curves, curve(
                               chart, [](const auto& point) { return point.q; }, chart.of.thermometer, ""));
      add_panel(check_sentence(language_, "thermometers_at", unit, shown(plateau)), word("standardised"),
                std::move(curves), assessment_.limits.thermometers.individuals);
    }
  }

  /// Draws for each thermometer the EWMA of the plateau at which it is largest.
  void add_ewma_of_thermometers(const std::string& unit) {
    std::vector<plot::Curve> curves;
    for (const Chart& chart : assessment_.charts) {
      if (chart.of.kind != CheckKind::thermometer || chart.of.axis != unit) continue;
      auto line = curve(
          chart, [](const auto& point) { return point.ewma; }, chart.of.thermometer, "");
      const auto same = std::ranges::find(curves, line.name, &plot::Curve::name);
      if (same == curves.end()) {
        add_line(curves, std::move(line));
        continue;
      }
      for (std::size_t r = 0; r < line.y.size(); ++r)
        if (std::abs(line.y[r]) > std::abs(same->y[r])) same->y[r] = line.y[r];
    }
    add_panel(check_sentence(language_, "ewma_thermometers", unit), word("of_limit"), std::move(curves), 1);
  }

  const assurance::Assessment& assessment_;
  bool simulated_;
  report::Language language_;
  std::string title_;
  std::vector<double> runs_;
  std::vector<plot::Panel> panels_;
};

/// Writes the page.
class CheckDocument {
 public:
  CheckDocument(const CheckedStandard& standard, report::Language language)
      : standard_(standard), language_(language) {}

  [[nodiscard]] report::Document document() && {
    const auto& head = standard_.history.head;
    heading("heading.standing");
    if (head.simulated) paragraph(word("simulated"), report::Paragraph::Style::caution);
    add_standing();
    if (standard_.diagnosis) add_cause();
    heading("heading.charts");
    blocks_.emplace_back(report::DocumentFigure{.id = "charts",
                                                .caption = word("caption"),
                                                .svg = to_svg(standard_, language_),
                                                .data = {.logarithmic = true}});  // no data: the page shows the SVG
    heading("heading.runs");
    add_runs();
    if (!standard_.history.explanations.empty()) add_explanations();
    return {.language = language_,
            .title = word("title"),
            .number = fmt::format("{}", fmt::join(head.serial_numbers, ", ")),
            .laboratory = head.rig,
            .logo = {},
            .mark = head.simulated ? std::string(report::translate(language_, "mark.simulated")) : "",
            .end = word("end"),
            .page_of = word("page_of"),
            .blocks = std::move(blocks_)};
  }

 private:
  [[nodiscard]] std::string word(std::string_view key) const { return std::string(check_word(language_, key)); }
  template <class... Values>
  [[nodiscard]] std::string sentence(std::string_view key, const Values&... values) const {
    return check_sentence(language_, key, values...);
  }
  [[nodiscard]] std::string number(double value, int decimals) const {
    return report::format_number(language_, value, decimals);
  }
  void heading(const std::string& key) {
    blocks_.emplace_back(report::Heading{.text = word(key), .id = key.substr(key.find('.') + 1)});
  }
  void paragraph(std::string text, report::Paragraph::Style style = report::Paragraph::Style::plain) {
    blocks_.emplace_back(report::Paragraph{style, std::move(text)});
  }

  void add_standing() {
    const auto& [file, history, assessment, diagnosis] = standard_;
    const auto open = std::ranges::count_if(assessment.runs, &assurance::RunVerdict::is_open);
    const auto runs = assessment.runs.size();
    const bool judges = !assessment.charts.empty() && assessment.charts.front().points.back().is_judged;
    if (open > 0)
      paragraph(sentence("open", open, runs), report::Paragraph::Style::caution);
    else
      paragraph(word(judges ? "in_control" : "learning"));
    blocks_.emplace_back(
        report::Definitions{{{word("rig"), history.head.rig},
                             {word("serials"), fmt::format("{}", fmt::join(history.head.serial_numbers, ", "))},
                             {word("profile"), history.head.profile},
                             {word("runs"), fmt::format("{}", runs)},
                             {word("last"), report::format_instant(language_, history.checks.back().started_utc)}}});
    const auto rate = report::format_plain(language_, history.head.false_alarm_rate);
    const auto lambda = report::format_plain(language_, assurance::kLambda);
    const auto& [gyro, thermometers] = assessment.limits;
    paragraph(sentence("rate", rate, assessment.charts.size(), number(gyro.individuals, 2), number(gyro.ewma, 2),
                       lambda, number(thermometers.individuals, 2), number(thermometers.ewma, 2)),
              report::Paragraph::Style::note);
  }

  [[nodiscard]] std::string cause(assurance::ChangeCause which) const {
    return word(std::string("cause.") + name(which));
  }

  /// Returns "x, constant" in the language of the page.
  [[nodiscard]] std::string part(const std::string& text) const {
    const auto comma = text.find(", ");
    if (comma == std::string::npos) return text;
    return text.substr(0, comma + 2) + word("part." + text.substr(comma + 2));
  }

  void add_cause() {
    const auto& diagnosis = *standard_.diagnosis;
    heading("heading.cause");
    const auto day = report::format_day(language_, standard_.history.checks[diagnosis.since].started_utc.substr(0, 10));
    std::string causes;
    for (int c = 0; c < 4; ++c) {
      constexpr double kMentioned = 0.05;
      if (diagnosis.probabilities[c] < kMentioned) continue;
      causes += (causes.empty() ? "" : ", ") + cause(static_cast<assurance::ChangeCause>(c)) + " " +
                report::format_probability(language_, diagnosis.probabilities[c]);
    }
    paragraph(sentence(diagnosis.named ? "named" : "not_named", causes, diagnosis.since + 1, day, diagnosis.before,
                       diagnosis.after));
    if (diagnosis.tilt_equals_drift) paragraph(word("equal"), report::Paragraph::Style::note);
    report::DocumentTable table{.caption = word("hypotheses_table"),
                                .header = {word("cause"), word("probability"), word("amount"), word("fit")}};
    constexpr double kListedOnPage = 0.005;
    for (const auto& one : diagnosis.hypotheses) {
      if (one.posterior < kListedOnPage) continue;
      const auto amount = std::isfinite(one.amount)
                              ? fmt::format("{} ± {} {}", number(one.amount, 4), number(one.amount_u, 4), one.unit)
                              : "–";
      table.rows.push_back({{.text = cause(one.cause), .note = part(one.part)},
                            {.text = report::format_probability(language_, one.posterior)},
                            {.text = amount},
                            {.text = report::format_probability(language_, one.fits)}});
    }
    blocks_.emplace_back(std::move(table));
  }

  [[nodiscard]] Cell verdict(std::size_t r) const {
    const auto& run = standard_.assessment.runs[r];
    if (run.explanation) return {.mark = Cell::Mark::caution, .text = word("verdict.explained")};
    if (run.is_out()) return {.mark = Cell::Mark::fail, .text = word("verdict.out")};
    const auto& charts = standard_.assessment.charts;
    if (charts.empty() || !charts.front().points[r].is_judged) return {.text = word("verdict.learning")};
    return {.mark = Cell::Mark::pass, .text = word("verdict.in")};
  }

  [[nodiscard]] std::string list_charts(std::size_t r) const {
    std::string text;
    for (const std::size_t c : standard_.assessment.runs[r].charts) {
      const auto& of = standard_.assessment.charts[c].of;
      if (!text.empty()) text += "; ";
      text += of.kind == CheckKind::thermometer ? word("cause.thermometer") + " " + of.thermometer
                                                : word("kind." + name(of.kind)) + " " + of.axis;
      if (!of.plateau.empty()) text += " " + shown(of.plateau);
    }
    return text.empty() ? "–" : text;
  }

  void add_runs() {
    report::DocumentTable table{.caption = word("runs_table"),
                                .header = {word("run"), word("day"), word("record"), word("verdict"), word("out_in")},
                                .text_columns = 5};
    for (std::size_t r = 0; r < standard_.history.checks.size(); ++r) {
      const auto& check = standard_.history.checks[r];
      table.rows.push_back({{.text = fmt::format("{}", r + 1)},
                            {.text = report::format_day(language_, check.started_utc.substr(0, 10))},
                            {.text = check.record, .note = "SHA-256 " + check.sha256.substr(0, 16) + "…"},
                            verdict(r),
                            {.text = list_charts(r)}});
    }
    blocks_.emplace_back(std::move(table));
  }

  void add_explanations() {
    heading("heading.explanations");
    report::DocumentTable table{.caption = word("explanations_table"),
                                .header = {word("day"), word("cause"), word("by"), word("runs"), word("note")},
                                .text_columns = 5};
    for (const auto& one : standard_.history.explanations) {
      auto note = one.note;
      if (one.new_level) note += (note.empty() ? "" : "; ") + word("new_level");
      table.rows.push_back({{.text = report::format_instant(language_, one.utc)},
                            {.text = word("cause." + one.cause), .note = one.part},
                            {.text = one.by},
                            {.text = fmt::format("{}", one.run_ids.size())},
                            {.text = note.empty() ? "–" : note}});
    }
    blocks_.emplace_back(std::move(table));
  }

  const CheckedStandard& standard_;
  report::Language language_;
  std::vector<report::Block> blocks_;
};

}  // namespace

std::string to_svg(const CheckedStandard& standard, report::Language language) {
  return ChartFigure(standard, language).svg();
}

std::string to_html(const CheckedStandard& standard, report::Language language) {
  return report::to_html(CheckDocument(standard, language).document());
}

}  // namespace gyrotherm::app
