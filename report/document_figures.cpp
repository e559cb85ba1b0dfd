// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "report/document_chart.hpp"
#include "report/document_parts.hpp"
#include "report/plot/plot.hpp"
#include "report/plot/svg.hpp"
#include "report/stored_texts.hpp"

namespace gyrotherm::report {
namespace {

/// If a figure has more lines than this, its legend omits the parts that all names have in common.
constexpr std::size_t kFewLines = 4;
constexpr std::size_t kLongestName = 28;
/// Maximum number of points of a line that reverses in x, such as the bias over temperature.
constexpr std::size_t kMostLoopPoints = 1500;

bool differs_between_lines(const FigureData& figure, auto FigureLine::*member) {
  return std::ranges::any_of(figure.lines,
                             [&](const FigureLine& line) { return line.*member != figure.lines.front().*member; });
}

std::string shorten_name(const std::string& name) {
  std::size_t letters = 0, end = 0;
  for (; end < name.size() && letters <= kLongestName; ++end)
    if ((static_cast<unsigned char>(name[end]) & 0xC0) != 0x80) ++letters;
  if (letters <= kLongestName) return name;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0) == 0x80) --end;
  return name.substr(0, end) + "…";
}

/// Reduces a line that reverses in x to the minimum and maximum y of consecutive sections.
plot::Points decimate_loop(const std::vector<double>& x, const std::vector<double>& y) {
  if (x.size() <= kMostLoopPoints) return {x, y};
  std::vector<double> order(x.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<double>(k);
  plot::Points kept = plot::decimate(order, y, kMostLoopPoints / 2);
  for (double& at : kept.x) at = x[static_cast<std::size_t>(at)];
  return kept;
}

/// Returns the number of temperature lines before this one.
std::size_t count_previous_temperatures(const FigureData& figure, std::size_t index) {
  const auto before = figure.lines.begin() + static_cast<std::ptrdiff_t>(index);
  return static_cast<std::size_t>(
      std::count_if(figure.lines.begin(), before, [](const FigureLine& line) { return line.key == "temperature"; }));
}

plot::Marker stage_marker(const FigureLine& line) {
  switch (line.stage) {
    case Stage::uncompensated: return plot::Marker::circle;
    case Stage::as_found: return plot::Marker::square;
    case Stage::as_left: return plot::Marker::diamond;
  }
  return plot::Marker::circle;
}

plot::Curve make_curve(const FigureData& figure, std::size_t index, std::string name) {
  const FigureLine& line = figure.lines[index];
  plot::Curve curve{.name = std::move(name), .colour = line_colour(figure, index), .x = line.x, .y = line.y};
  curve.width_px = line.stage == Stage::as_left ? 1.6 : 1.2;
  curve.dashed = is_line_dashed(figure, index);
  curve.error = line.error;
  if (figure.logarithmic) curve.marker = stage_marker(line);
  if (!std::ranges::is_sorted(line.x)) {
    plot::Points kept = decimate_loop(line.x, line.y);
    curve.x = std::move(kept.x);
    curve.y = std::move(kept.y);
    curve.error.clear();
  }
  return curve;
}

plot::AxisStyle axis_style(const DocumentWriter& writer, const std::string& key, const std::string& unit,
                           bool logarithmic) {
  return {.title = remove_word_joiners(name_with_unit(writer.translated(key), unit)), .logarithmic = logarithmic};
}

std::string figure_caption(const DocumentWriter& writer, const FigureData& figure) {
  std::string caption = writer.translated(figure.key);
  if (!figure.axis.empty()) caption += ", " + figure.axis;
  if (const std::string record = record_label(writer.report, figure.run); !record.empty()) caption += ", " + record;
  const bool has_errors = std::ranges::any_of(figure.lines, [](const FigureLine& line) { return !line.error.empty(); });
  return has_errors ? caption + ". " + writer.translated("say.error_bars") : caption;
}

/// Width of a figure for a narrow screen.
constexpr double kNarrowPx = 330;

std::string to_svg(const DocumentWriter& writer, const FigureData& figure, const std::string& id,
                   const std::string& caption, double width_px = plot::Plot{}.width_px) {
  const std::string mark = document_mark(writer);
  plot::Plot plot{.id = id,
                  .title = caption,
                  .x = axis_style(writer, figure.x_key, figure.x_unit, figure.logarithmic),
                  .simulated = !mark.empty(),
                  .width_px = width_px,
                  .language = {.decimal_comma = writer.language == Language::german, .simulated = mark}};
  plot::Panel panel;
  panel.left = axis_style(writer, figure.y_key, figure.y_unit, figure.logarithmic);
  for (std::size_t k = 0; k < figure.lines.size(); ++k)
    panel.curves.push_back(make_curve(figure, k, shorten_name(line_name(writer.language, figure, k))));
  plot.panels.push_back(std::move(panel));
  return plot::to_svg(plot);
}

}  // namespace

std::string line_colour(const FigureData& figure, std::size_t index) {
  const FigureLine& line = figure.lines[index];
  if (line.key == "set_point") return plot::colour::kSetPoint;
  if (line.key == "temperature") return plot::palette(count_previous_temperatures(figure, index));
  switch (line.stage) {
    case Stage::uncompensated: return line.key == "fit" ? plot::colour::kInk : plot::colour::kFaintInk;
    case Stage::as_found: return plot::colour::kThreePoint;
    case Stage::as_left: return plot::colour::kBias;
  }
  return plot::colour::kInk;
}

bool is_line_dashed(const FigureData& figure, std::size_t index) {
  const FigureLine& line = figure.lines[index];
  if (line.key == "temperature") return count_previous_temperatures(figure, index) >= plot::kPaletteSize;
  return line.key == "set_point" || line.key == "fit" || line.stage == Stage::as_found;
}

std::string line_name(Language language, const FigureData& figure, std::size_t index) {
  const FigureLine& line = figure.lines[index];
  std::string name;
  const auto join = [&](std::string_view part) { name += (name.empty() ? "" : " ") + std::string(part); };
  const bool crowded = figure.lines.size() > kFewLines && !line.detail.empty();
  const bool has_stages = differs_between_lines(figure, &FigureLine::stage);
  const bool has_keys = differs_between_lines(figure, &FigureLine::key);
  if (!crowded && (has_keys || (!has_stages && line.detail.empty()))) join(translate(language, line.key));
  if (!line.detail.empty()) join(translate_thermometer(language, line.detail));
  if (!has_stages) return name;
  const std::string_view stage = translate(language, report::name(line.stage));
  if (name.empty()) return std::string(stage);
  return line.key == "set_point" || line.key == "temperature" ? name : name + ", " + std::string(stage);
}

void add_figures(DocumentWriter& writer, const std::string& axis) {
  const std::vector<FigureData>& all = writer.report.figures;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const FigureData& figure = all[k];
    if (figure.axis != axis || figure.lines.empty()) continue;
    const std::string id = fmt::format("figure-{}", k + 1);
    const std::string caption = figure_caption(writer, figure);
    writer.add(DocumentFigure{
        .id = id,
        .caption = caption,
        .svg = to_svg(writer, figure, id, caption),
        .narrow_svg = can_be_enlarged(figure) ? "" : to_svg(writer, figure, id + "-narrow", caption, kNarrowPx),
        .data = figure});
  }
}

}  // namespace gyrotherm::report
