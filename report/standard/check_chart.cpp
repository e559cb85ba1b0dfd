// SPDX-License-Identifier: Apache-2.0
#include "report/standard/check_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "report/plot/plot.hpp"
#include "report/plot/svg.hpp"
#include "report/standard/check_words.hpp"

namespace gyrotherm::standard {
namespace {

using assurance::Chart;
using assurance::CheckKind;

constexpr const char *kBlue = "#0072b2", *kGrey = "#6b7785", *kRed = "#c8401b";
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kPanelHeight = 120;

/// Draws the control charts of one history.
class ChartFigure {
 public:
  ChartFigure(const CheckedStandard& standard, const ChartStyle& style, std::size_t panels_per_sheet)
      : panels_per_sheet_(panels_per_sheet),
        assessment_(standard.assessment),
        simulated_(standard.history.head.simulated),
        language_(style.language),
        width_px_(style.width_px),
        description_(describe_standing(standard, style.language)) {
    for (std::size_t r = 0; r < standard.history.checks.size(); ++r) runs_.push_back(static_cast<double>(r + 1));
    title_ = check_sentence(language_, "charts_of",
                            fmt::format("{}", fmt::join(standard.history.head.serial_numbers, ", ")));
  }

  [[nodiscard]] std::vector<std::string> sheets() && {
    for (const std::string& axis : list_axes(false)) {
      for (const Chart& chart : assessment_.charts)
        if (chart.of.kind != CheckKind::thermometer && chart.of.axis == axis) add_individuals(chart);
      add_ewma(axis);
    }
    for (const std::string& unit : list_axes(true)) {
      add_thermometers(unit);
      add_ewma_of_thermometers(unit);
    }
    std::vector<std::string> sheets;
    for (std::size_t first = 0; first < panels_.size(); first += panels_per_sheet_) {
      const auto last = std::min(panels_.size(), first + panels_per_sheet_);
      sheets.push_back(draw_sheet(sheets.size(), {panels_.begin() + static_cast<std::ptrdiff_t>(first),
                                                  panels_.begin() + static_cast<std::ptrdiff_t>(last)}));
    }
    return sheets;
  }

 private:
  [[nodiscard]] std::string draw_sheet(std::size_t number, std::vector<plot::Panel> panels) const {
    return plot::to_svg(
        {.id = number == 0 ? "control-charts" : fmt::format("control-charts-{}", number + 1),
         .title = title_,
         .description = description_,
         .x = {.title = word("run"), .range = plot::Range{0, runs_.back() + 1}},
         .panels = std::move(panels),
         .simulated = simulated_,
         .width_px = width_px_,
         .language = {.decimal_comma = language_ == plot::Language::german, .simulated = word("mark")}});
  }

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
    const bool is_first = panels_.size() % panels_per_sheet_ == 0;
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
    if (!chart.of.plateau.empty()) title += ", " + shown_plateau(chart.of.plateau);
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
          chart.of.kind == CheckKind::bias ? shown_plateau(chart.of.plateau) : word("short." + name(chart.of.kind));
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
      add_panel(check_sentence(language_, "thermometers_at", unit, shown_plateau(plateau)), word("standardised"),
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

  std::size_t panels_per_sheet_;
  const assurance::Assessment& assessment_;
  bool simulated_;
  plot::Language language_;
  double width_px_;
  std::string description_, title_;
  std::vector<double> runs_;
  std::vector<plot::Panel> panels_;
};

}  // namespace

std::string to_svg(const CheckedStandard& standard, const ChartStyle& style) {
  return ChartFigure(standard, style, std::numeric_limits<std::size_t>::max()).sheets().front();
}

std::vector<ChartSheet> to_svg_sheets(const CheckedStandard& standard, const ChartStyle& style) {
  constexpr std::size_t kPanelsPerSheet = 4;
  const auto figures = ChartFigure(standard, style, kPanelsPerSheet).sheets();
  std::vector<ChartSheet> sheets;
  for (std::size_t i = 0; i < figures.size(); ++i)
    sheets.push_back({.svg = figures[i],
                      .caption = i == 0 ? std::string(check_word(style.language, "caption"))
                                        : check_sentence(style.language, "caption_more", i + 1, figures.size())});
  return sheets;
}

std::string describe_standing(const CheckedStandard& standard, plot::Language language) {
  const auto& assessment = standard.assessment;
  const auto open = std::ranges::count_if(assessment.runs, &assurance::RunVerdict::is_open);
  if (open > 0) return check_sentence(language, "open", open, assessment.runs.size());
  const bool judges = !assessment.charts.empty() && assessment.charts.front().points.back().is_judged;
  return std::string(check_word(language, judges ? "in_control" : "learning"));
}

std::string shown_plateau(const std::string& plateau) {
  return plateau.starts_with('-') ? "−" + plateau.substr(1) : plateau;
}

}  // namespace gyrotherm::standard
