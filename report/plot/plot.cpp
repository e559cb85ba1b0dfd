// SPDX-License-Identifier: Apache-2.0
#include "report/plot/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "report/plot/svg.hpp"

namespace gyrotherm::plot {

namespace {

/// A tick within this fraction of a step from the end of the range is treated as being at the end.
constexpr double kRounding = 1e-6;

Range extend_to_step(const Range& range, double step) {
  const Range out{step * std::floor(range.low / step + kRounding), step * std::ceil(range.high / step - kRounding)};
  return out.high > out.low ? out : Range{out.low - step, out.low + step};
}

/// Returns the range of the finite values above a bound; nothing if there is none.
std::optional<Range> finite_extremes(const std::vector<double>& values, double above) {
  std::optional<Range> range;
  for (const double value : values)
    if (std::isfinite(value) && value > above)
      range = range ? Range{std::min(range->low, value), std::max(range->high, value)} : Range{value, value};
  return range;
}

/// Indices of the minimum and maximum of one column.
struct Extremes {
  std::size_t least{};
  std::size_t greatest{};
};

class Thinner {
 public:
  Thinner(const std::vector<double>& x, const std::vector<double>& y) : x_(x), y_(y) {}

  void take(std::size_t k) {
    if (!open_) extremes_ = {k, k};
    open_ = true;
    if (y_[k] < y_[extremes_.least]) extremes_.least = k;
    if (y_[k] > y_[extremes_.greatest]) extremes_.greatest = k;
  }
  void close_column() {
    if (!open_) return;
    const auto [first, second] = std::minmax(extremes_.least, extremes_.greatest);
    keep(first);
    if (second != first) keep(second);
    open_ = false;
  }
  void break_line(double x) {
    close_column();
    if (kept_.y.empty() || std::isnan(kept_.y.back())) return;
    kept_.x.push_back(x);
    kept_.y.push_back(std::numeric_limits<double>::quiet_NaN());
  }
  [[nodiscard]] Points finish() && {
    close_column();
    return std::move(kept_);
  }

 private:
  void keep(std::size_t k) {
    kept_.x.push_back(x_[k]);
    kept_.y.push_back(y_[k]);
  }

  const std::vector<double>& x_;
  const std::vector<double>& y_;
  Extremes extremes_;
  bool open_ = false;
  Points kept_;
};

constexpr double kLeftMargin = 64;
constexpr double kRightMargin = 16;
constexpr double kRightAxisMargin = 64;
// Head height of a panel with one legend row.
constexpr double kHeadHeight = 34;
// Space below the last panel for tick labels and the x title.
constexpr double kFootHeight = 46;
constexpr double kPanelGap = 22;
constexpr double kXTitleSize = 12;
// Line of the tag SIMULATED below an x title that leaves no space for it.
constexpr double kTagHeight = 14;
// Space above the head of the first panel for the names of stretches.
constexpr double kStretchHeight = 6;
constexpr double kTickLength = 4;
constexpr int kXTicks = 8;
// Margin above and below the data, relative to their range.
constexpr double kDataMargin = 0.02;

int y_tick_count(const Panel& panel) { return std::max(3, static_cast<int>(panel.height_px / 42)); }

constexpr double kKeyWidth = 20, kKeyGap = 5, kEntryGap = 14, kLegendSize = 11, kLegendRow = 16;

struct LegendEntry {
  const Curve* curve{};  ///< null: entry of a band
  std::string name;
  [[nodiscard]] double width() const { return kKeyWidth + kKeyGap + text_width(name, kLegendSize) + kEntryGap; }
};

struct LegendRow {
  std::vector<LegendEntry> entries{};
  [[nodiscard]] double width() const {
    double sum = 0;
    for (const LegendEntry& entry : entries) sum += entry.width();
    return sum;
  }
};

/// Arranges the entries in the order of the curves; fills each row up to the width of the plotting area.
std::vector<LegendRow> legend_rows(const Panel& panel, double width_px) {
  std::vector<LegendRow> rows;
  const auto add = [&](LegendEntry entry) {
    if (rows.empty() || rows.back().width() + entry.width() - kEntryGap > width_px) rows.emplace_back();
    rows.back().entries.push_back(std::move(entry));
  };
  for (const Curve& curve : panel.curves)
    if (!curve.name.empty()) add({&curve, curve.name});
  for (const Band& band : panel.bands) add({nullptr, band.name});
  return rows;
}

/// Returns the upward shift of the last legend row. Only a single row fits next to a title.
double legend_shift(const Panel& panel, std::size_t rows) { return rows > 1 && !panel.title.empty() ? kLegendRow : 0; }

/// Returns the height of the title and legend of a panel.
double head_height(const Panel& panel, double width_px) {
  const auto rows = std::max<std::size_t>(1, legend_rows(panel, width_px).size());
  return kHeadHeight + kLegendRow * static_cast<double>(rows - 1) + legend_shift(panel, rows);
}

/// Position of a panel and its scales.
struct PanelLayout {
  double left_px{}, top_px{}, width_px{}, height_px{};
  Scale x, y, y_right;
  [[nodiscard]] double right_px() const { return left_px + width_px; }
  [[nodiscard]] double bottom_px() const { return top_px + height_px; }
  [[nodiscard]] const Scale& scale(Side side) const { return side == Side::left ? y : y_right; }
};

/// Returns the range of the positive values of one side's curves, error bars included.
Range logarithmic_range(const Panel& panel, Side side) {
  std::vector<double> ends;
  for (const Curve& curve : panel.curves) {
    if (curve.side != side) continue;
    for (std::size_t k = 0; k < curve.y.size(); ++k) {
      const double error = curve.error.empty() ? 0 : curve.error[k];
      ends.insert(ends.end(), {curve.y[k], curve.y[k] - error, curve.y[k] + error});
    }
  }
  return round_out_logarithmically(find_positive_range(ends));
}

Range y_range(const Panel& panel, Side side) {
  const AxisStyle& style = side == Side::left ? panel.left : *panel.right;
  if (style.range) return *style.range;
  if (!style.categories.empty()) return {-0.6, static_cast<double>(style.categories.size()) - 0.4};
  if (style.logarithmic) return logarithmic_range(panel, side);
  std::optional<Range> range;
  for (const Curve& curve : panel.curves) {
    if (curve.side != side) continue;
    range = range ? join_ranges(*range, value_range(curve.y)) : value_range(curve.y);
  }
  if (side == Side::left) {
    for (const Band& band : panel.bands) range = range ? join_ranges(*range, band.range) : band.range;
  }
  const Range tight = range.value_or(Range{0, 1});
  const double air = kDataMargin * (tight.high - tight.low);
  return round_out({tight.low - air, tight.high + air}, y_tick_count(panel));
}

Range x_range(const Plot& plot) {
  if (plot.x.range) return *plot.x.range;
  if (!plot.x.categories.empty()) return {-0.4, static_cast<double>(plot.x.categories.size()) - 0.6};
  std::optional<Range> range;
  for (const Panel& panel : plot.panels) {
    for (const Curve& curve : panel.curves)
      range = range ? join_ranges(*range, value_range(curve.x)) : value_range(curve.x);
  }
  Range whole = range.value_or(Range{0, 1});
  if (plot.x.logarithmic) return round_out_logarithmically(find_positive_range({whole.low, whole.high}));
  if (whole.high <= whole.low) whole.high = whole.low + 1;
  return whole;
}

std::vector<Tick> make_ticks(const AxisStyle& style, const Range& range, int count) {
  std::vector<Tick> all;
  for (const std::string& name : style.categories) all.push_back({static_cast<double>(all.size()), name});
  if (!all.empty()) return all;
  return style.logarithmic ? logarithmic_ticks(range) : ticks(range, count);
}

std::vector<Tick> make_y_ticks(const Panel& panel, const PanelLayout& layout, Side side) {
  return make_ticks(side == Side::left ? panel.left : *panel.right, layout.scale(side).values, y_tick_count(panel));
}

std::vector<Tick> make_x_ticks(const Plot& plot) { return make_ticks(plot.x, x_range(plot), kXTicks); }

void draw_background(SvgWriter& svg, const Plot& plot, const Panel& panel, const PanelLayout& layout) {
  for (const Band& band : panel.bands) {
    const double top = std::max(layout.y(band.range.high), layout.top_px);
    const double bottom = std::min(layout.y(band.range.low), layout.bottom_px());
    if (bottom > top) svg.rectangle(layout.left_px, top, layout.width_px, bottom - top, colour::kFloor);
  }
  const auto grid_colour = [](const Tick& tick) { return tick.label.empty() ? colour::kFineGrid : colour::kGrid; };
  for (const Tick& tick : make_x_ticks(plot)) {
    const double x = layout.x(tick.value);
    svg.line(x, layout.top_px, x, layout.bottom_px(), {grid_colour(tick)});
  }
  for (const Tick& tick : make_y_ticks(panel, layout, Side::left)) {
    const double y = layout.y(tick.value);
    svg.line(layout.left_px, y, layout.right_px(), y, {tick.value == 0 ? "#b9c1ca" : grid_colour(tick)});
  }
  if (plot.simulated)
    draw_simulated_mark(svg, layout.left_px, layout.top_px, layout.width_px, layout.height_px, plot.language.simulated);
}

/// Returns the label of a tick with the decimal sign of the language. Categories are names and remain unchanged.
std::string tick_label(const Plot& plot, const Tick& tick, bool is_category) {
  std::string label = tick.label;
  if (plot.language.decimal_comma && !is_category) std::ranges::replace(label, '.', ',');
  return label;
}

void draw_y_axis(SvgWriter& svg, const Plot& plot, const Panel& panel, const PanelLayout& layout, Side side) {
  const AxisStyle& style = side == Side::left ? panel.left : *panel.right;
  const bool left = side == Side::left;
  const double edge = left ? layout.left_px : layout.right_px();
  const double outwards = left ? -1 : 1;
  for (const Tick& tick : make_y_ticks(panel, layout, side)) {
    const double y = layout.scale(side)(tick.value);
    svg.line(edge, y, edge + outwards * kTickLength * (tick.label.empty() ? 0.5 : 1), y, {colour::kFaintInk});
    if (tick.label.empty()) continue;
    svg.text(edge + outwards * (kTickLength + 4), y + 3.8, tick_label(plot, tick, !style.categories.empty()),
             {.colour = style.colour, .anchor = left ? Anchor::end : Anchor::start});
  }
  const double middle = layout.top_px + layout.height_px / 2;
  svg.text(left ? 15 : edge + 56, middle, style.title,
           {.size_px = 12, .colour = style.colour, .anchor = Anchor::middle, .turned_deg = 90});
}

void draw_x_axis(SvgWriter& svg, const Plot& plot, const PanelLayout& layout, bool labelled) {
  for (const Tick& tick : make_x_ticks(plot)) {
    const double x = layout.x(tick.value);
    svg.line(x, layout.bottom_px(), x, layout.bottom_px() + kTickLength * (tick.label.empty() ? 0.5 : 1),
             {colour::kFaintInk});
    if (!labelled || tick.label.empty()) continue;
    svg.text(x, layout.bottom_px() + 17, tick_label(plot, tick, !plot.x.categories.empty()),
             {.anchor = Anchor::middle});
  }
  if (!labelled) return;
  svg.text(layout.left_px + layout.width_px / 2, layout.bottom_px() + 36, plot.x.title,
           {.size_px = kXTitleSize, .anchor = Anchor::middle});
}

/// Returns whether the tag of a simulated plot would overlap the x title, which is centred below a panel of this width.
bool needs_tag_line(const Plot& plot, double width_px) {
  return plot.simulated &&
         text_width(plot.x.title, kXTitleSize) / 2 + simulated_tag_width(plot.language.simulated) > width_px / 2;
}

/// Returns the path of a curve. Coordinates are absolute, so rounding errors do not accumulate.
std::string path_data(const Curve& curve, const PanelLayout& layout) {
  const Points points = decimate(curve.x, curve.y, static_cast<std::size_t>(layout.width_px));
  const Scale& scale = layout.scale(curve.side);
  std::string data;
  const auto is_drawn = [&](std::size_t k) {
    return k < points.x.size() && std::isfinite(points.x[k]) && std::isfinite(points.y[k]) &&
           (!scale.logarithmic || points.y[k] > 0) && (!layout.x.logarithmic || points.x[k] > 0);
  };
  bool drawing = false;
  for (std::size_t k = 0; k < points.x.size(); ++k) {
    const bool here = is_drawn(k);
    if (here) {
      const std::string x = pixels(layout.x(points.x[k]));
      if (drawing && curve.steps) data += "H" + x;
      data += fmt::format("{}{} {}", drawing ? "L" : "M", x, pixels(scale(points.y[k])));
      // An isolated point would have no visible line; draw a dot.
      if (!drawing && !is_drawn(k + 1)) data += "h" + pixels(curve.width_px);
    }
    drawing = here;
  }
  return data;
}

std::string marker_data(Marker marker, double x, double y) {
  constexpr double r = 3.4;
  const auto at = [&](double dx, double dy) { return pixels(x + dx) + " " + pixels(y + dy); };
  switch (marker) {
    case Marker::none: return "";
    case Marker::circle: return fmt::format("M{0}a{1} {1} 0 1 0 {2} 0a{1} {1} 0 1 0 -{2} 0z", at(-r, 0), r, 2 * r);
    case Marker::square: return "M" + at(-r, -r) + "L" + at(r, -r) + "L" + at(r, r) + "L" + at(-r, r) + "z";
    case Marker::diamond:
      return "M" + at(0, -r - 1) + "L" + at(r + 1, 0) + "L" + at(0, r + 1) + "L" + at(-r - 1, 0) + "z";
    case Marker::triangle: return "M" + at(0, -r - 1) + "L" + at(r + 0.6, r) + "L" + at(-r - 0.6, r) + "z";
  }
  return "";
}

void draw_marker(SvgWriter& svg, const Curve& curve, double x, double y) {
  if (curve.marker == Marker::none) return;
  svg.shape(marker_data(curve.marker, x, y), curve.hollow ? "#ffffff" : curve.colour, curve.colour);
}

/// Draws a bar from y − error to y + error with a cap at each end, clipped to the plotting area.
void draw_error_bars(SvgWriter& svg, const Curve& curve, const PanelLayout& layout) {
  constexpr double kHalfCap_px = 3;
  const Scale& scale = layout.scale(curve.side);
  for (std::size_t k = 0; k < curve.error.size(); ++k) {
    const double x = layout.x(curve.x[k]);
    const double low = std::min(scale(curve.y[k] - curve.error[k]), layout.bottom_px());
    const double high = std::max(scale(curve.y[k] + curve.error[k]), layout.top_px);
    if (!(low > high)) continue;
    svg.line(x, low, x, high, {curve.colour});
    for (const double end : {low, high}) {
      if (end < layout.bottom_px() && end > layout.top_px)
        svg.line(x - kHalfCap_px, end, x + kHalfCap_px, end, {curve.colour});
    }
  }
}

void draw_curve(SvgWriter& svg, const Curve& curve, const PanelLayout& layout, const std::string& clip) {
  assert(curve.x.size() == curve.y.size());
  assert(curve.error.empty() || curve.error.size() == curve.y.size());
  draw_error_bars(svg, curve, layout);
  if (curve.line) svg.path(path_data(curve, layout), {curve.colour, curve.width_px, curve.dashed ? "6 3" : ""}, clip);
  const Scale& scale = layout.scale(curve.side);
  for (std::size_t k = 0; k < curve.x.size() && curve.marker != Marker::none; ++k) {
    const bool inside = curve.y[k] >= scale.values.low && curve.y[k] <= scale.values.high;
    if (inside) draw_marker(svg, curve, layout.x(curve.x[k]), scale(curve.y[k]));
  }
}

void draw_legend_entry(SvgWriter& svg, const LegendEntry& entry, double x, double y) {
  if (entry.curve == nullptr) {
    svg.rectangle(x, y - 5, kKeyWidth, 10, colour::kFloor);
  } else {
    const Curve& curve = *entry.curve;
    if (curve.line)
      svg.line(x, y, x + kKeyWidth, y, {curve.colour, std::max(1.6, curve.width_px), curve.dashed ? "6 3" : ""});
    draw_marker(svg, curve, x + kKeyWidth / 2, y);
  }
  svg.text(x + kKeyWidth + kKeyGap, y + 3.8, entry.name, {.size_px = kLegendSize});
}

/// Draws the legend rows right-aligned; the last row is directly above the plotting area.
void draw_legend(SvgWriter& svg, const Panel& panel, const PanelLayout& layout) {
  const auto rows = legend_rows(panel, layout.width_px);
  double y = layout.top_px - 13 - kLegendRow * static_cast<double>(rows.size()) - legend_shift(panel, rows.size());
  for (const LegendRow& row : rows) {
    y += kLegendRow;
    double x = layout.right_px() - row.width() + kEntryGap;
    for (const LegendEntry& entry : row.entries) {
      draw_legend_entry(svg, entry, x, y);
      x += entry.width();
    }
  }
}

void draw_rules(SvgWriter& svg, const Panel& panel, const PanelLayout& layout) {
  for (const Rule& rule : panel.rules) {
    const double y = layout.y(rule.value);
    if (y < layout.top_px || y > layout.bottom_px()) continue;
    svg.line(layout.left_px, y, layout.right_px(), y, {colour::kFaintInk, 1, "3 3"});
    svg.text(layout.right_px() - 4, y - 4, rule.name,
             {.size_px = 10, .colour = colour::kFaintInk, .anchor = Anchor::end});
  }
}

void draw_stretches(SvgWriter& svg, const Plot& plot, const PanelLayout& layout, bool named) {
  for (const Stretch& stretch : plot.stretches) {
    const double from = layout.x(stretch.range.low), to = layout.x(stretch.range.high);
    if (stretch.range.low > layout.x.values.low)
      svg.line(from, layout.top_px, from, layout.bottom_px(), {"#8b95a1", 1, "1 2"});
    if (!named || to - from < text_width(stretch.name, 10)) continue;
    svg.text((from + to) / 2, layout.top_px - head_height(plot.panels.front(), layout.width_px) + 6, stretch.name,
             {.size_px = 10.5, .colour = colour::kFaintInk, .anchor = Anchor::middle});
  }
}

void draw_panel(SvgWriter& svg, const Plot& plot, std::size_t index, const PanelLayout& layout) {
  const Panel& panel = plot.panels[index];
  const std::string clip = fmt::format("{}-clip-{}", plot.id, index);
  svg.clip_region(clip, layout.left_px, layout.top_px, layout.width_px, layout.height_px);
  draw_background(svg, plot, panel, layout);
  draw_stretches(svg, plot, layout, index == 0);
  for (const Curve& curve : panel.curves) draw_curve(svg, curve, layout, clip);
  draw_rules(svg, panel, layout);
  svg.frame(layout.left_px, layout.top_px, layout.width_px, layout.height_px, {"#8b95a1"});
  draw_y_axis(svg, plot, panel, layout, Side::left);
  if (panel.right) draw_y_axis(svg, plot, panel, layout, Side::right);
  draw_x_axis(svg, plot, layout, index + 1 == plot.panels.size());
  svg.text(layout.left_px, layout.top_px - 9, panel.title, {.size_px = 12, .bold = true});
  draw_legend(svg, panel, layout);
}

PanelLayout lay_out_panel(const Plot& plot, const Panel& panel, double top_px, double width_px) {
  PanelLayout layout{kLeftMargin, top_px, width_px, panel.height_px, {}, {}, {}};
  layout.x = {x_range(plot), layout.left_px, layout.right_px(), plot.x.logarithmic};
  layout.y = {y_range(panel, Side::left), layout.bottom_px(), layout.top_px, panel.left.logarithmic};
  if (panel.right) {
    layout.y_right = {y_range(panel, Side::right), layout.bottom_px(), layout.top_px, panel.right->logarithmic};
  }
  return layout;
}

}  // namespace

Range value_range(const std::vector<double>& values) {
  return finite_extremes(values, -std::numeric_limits<double>::infinity()).value_or(Range{0, 1});
}

Range join_ranges(const Range& a, const Range& b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }

double tick_step(const Range& range, int count) {
  const double width = range.high > range.low ? range.high - range.low : 1.0;
  const double rough = width / count;
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  const double digit = rough / decade;
  return decade * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

Range round_out(const Range& range, int count) {
  double step = tick_step(range, count);
  Range out = extend_to_step(range, step);
  // A wider range may require a wider step. Its ends must be ticks of that step.
  while (tick_step(out, count) > step * (1 + kRounding)) {
    step = tick_step(out, count);
    out = extend_to_step(range, step);
  }
  return out;
}

Range find_positive_range(const std::vector<double>& values) {
  return finite_extremes(values, 0).value_or(Range{1, 10});
}

Range round_out_logarithmically(const Range& range) {
  const auto rounded = [](double value, bool up) {
    const double decade = std::pow(10.0, std::floor(std::log10(value) + kRounding));
    const double digit = value / decade;
    if (up) return decade * (digit <= 1 + kRounding ? 1 : digit <= 2 + kRounding ? 2 : digit <= 5 + kRounding ? 5 : 10);
    return decade * (digit < 2 - kRounding ? 1 : digit < 5 - kRounding ? 2 : 5);
  };
  const Range out{rounded(range.low, false), rounded(range.high, true)};
  return out.high > out.low ? out : Range{out.low, 10 * out.low};
}

std::vector<Tick> logarithmic_ticks(const Range& range) {
  constexpr double kMaxLabelledRatio = 100;  // two decades
  const bool label_all = range.high < kMaxLabelledRatio * range.low;
  std::vector<Tick> all;
  const int last = static_cast<int>(std::floor(std::log10(range.high) + kRounding));
  for (int exponent = static_cast<int>(std::floor(std::log10(range.low))); exponent <= last; ++exponent) {
    for (int digit = 1; digit < 10; ++digit) {
      const double value = digit * std::pow(10.0, exponent);
      if (value < range.low * (1 - kRounding) || value > range.high * (1 + kRounding)) continue;
      const bool labelled = digit == 1 || (label_all && (digit == 2 || digit == 5));
      all.push_back({value, labelled ? digit_and_power(digit, exponent) : ""});
    }
  }
  return all;
}

double Scale::operator()(double value) const {
  const auto along = [&](double low, double at, double high) {
    return from_px + (at - low) / (high - low) * (to_px - from_px);
  };
  if (!logarithmic) return along(values.low, value, values.high);
  if (!(value > 0)) return std::isnan(value) ? value : from_px;
  return along(std::log(values.low), std::log(value), std::log(values.high));
}

std::vector<Tick> ticks(const Range& range, int count) {
  const double step = tick_step(range, count);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + kRounding)));
  const auto first = std::llround(std::ceil(range.low / step - kRounding));
  const auto last = std::llround(std::floor(range.high / step + kRounding));
  std::vector<Tick> all;
  for (auto k = first; k <= last; ++k) {
    const double value = static_cast<double>(k) * step;
    all.push_back({value, decimal(value, decimals)});
  }
  return all;
}

Panel make_panel(std::string title, std::string left_title, std::vector<Curve> curves, double height_px) {
  Panel panel;
  panel.title = std::move(title);
  panel.left.title = std::move(left_title);
  panel.curves = std::move(curves);
  panel.height_px = height_px;
  return panel;
}

Points decimate(const std::vector<double>& x, const std::vector<double>& y, std::size_t columns) {
  assert(x.size() == y.size() && columns > 0);
  if (x.size() <= 2 * columns) return {x, y};
  const double width = (x.back() - x.front()) / static_cast<double>(columns);
  Thinner thinner(x, y);
  auto column = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(y[k])) {
      thinner.break_line(x[k]);
      continue;
    }
    const double own = std::floor((x[k] - x.front()) / width);
    if (own != column) thinner.close_column();
    column = own;
    thinner.take(k);
  }
  return std::move(thinner).finish();
}

Points break_at_gaps(const std::vector<double>& x, const std::vector<double>& y, double step) {
  assert(x.size() == y.size());
  constexpr double kMaxSteps = 1.5;  // steps between neighbours
  Points broken;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (k > 0 && x[k] - x[k - 1] > kMaxSteps * step) {
      broken.x.push_back(x[k - 1] + step);
      broken.y.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    broken.x.push_back(x[k]);
    broken.y.push_back(y[k]);
  }
  return broken;
}

std::string to_svg(const Plot& plot) {
  const bool two_axes = std::ranges::any_of(plot.panels, [](const Panel& panel) { return panel.right.has_value(); });
  const double right_margin = two_axes ? kRightAxisMargin : kRightMargin;
  const double first_top = plot.stretches.empty() ? 0 : kStretchHeight;
  double height = first_top + kFootHeight - kPanelGap;
  const double width = plot.width_px - kLeftMargin - right_margin;
  for (const Panel& panel : plot.panels) height += head_height(panel, width) + panel.height_px + kPanelGap;
  if (needs_tag_line(plot, width)) height += kTagHeight;
  SvgWriter svg(plot.width_px, height, plot.simulated ? plot.language.simulated + " – " + plot.title : plot.title,
                plot.description);
  double top = first_top;
  for (std::size_t k = 0; k < plot.panels.size(); ++k) {
    top += head_height(plot.panels[k], width);
    draw_panel(svg, plot, k, lay_out_panel(plot, plot.panels[k], top, width));
    top += plot.panels[k].height_px + kPanelGap;
  }
  if (plot.simulated) draw_simulated_tag(svg, plot.width_px - right_margin, height - 8, plot.language.simulated);
  return std::move(svg).finish();
}

namespace {

constexpr double kCellWidth = 66;
constexpr double kCellHeight = 34;
constexpr double kMapLeft = 64;
constexpr double kMapTop = 30;
constexpr double kMapFoot = 30;

void draw_cell(SvgWriter& svg, const HeatMap& map, std::size_t row, std::size_t column) {
  const double x = kMapLeft + kCellWidth * static_cast<double>(column);
  const double y = kMapTop + kCellHeight * static_cast<double>(row);
  const double value = map.values[row][column];
  const bool diagonal = row == column;
  const bool above = value > map.threshold;
  svg.rectangle(x, y, kCellWidth, kCellHeight, diagonal ? "#eef0f3" : shade_colour(value));
  svg.frame(x, y, kCellWidth, kCellHeight, {"#ffffff", 1.5, ""});
  svg.text(x + kCellWidth / 2, y + kCellHeight / 2 + 4.2, diagonal ? "0" : decimal(value, 3),
           {.size_px = 12,
            .colour = diagonal               ? colour::kFaintInk
                      : is_shade_dark(value) ? "#ffffff"
                                             : colour::kInk,
            .anchor = Anchor::middle,
            .bold = above});
}

void draw_selection_frame(SvgWriter& svg, const HeatMap& map, std::size_t row, std::size_t column) {
  if (!(map.values[row][column] > map.threshold)) return;
  svg.frame(kMapLeft + kCellWidth * static_cast<double>(column) + 1.5,
            kMapTop + kCellHeight * static_cast<double>(row) + 1.5, kCellWidth - 3, kCellHeight - 3,
            {"#e69f00", 1.8, ""});
}

}  // namespace

std::string to_svg(const HeatMap& map) {
  const auto count = map.names.size();
  const double width = kCellWidth * static_cast<double>(count), height = kCellHeight * static_cast<double>(count);
  SvgWriter svg(kMapLeft + width + 16, kMapTop + height + kMapFoot,
                map.simulated ? "SIMULATED – " + map.title : map.title);
  for (std::size_t row = 0; row < count; ++row) {
    const double along = static_cast<double>(row) + 0.5;
    svg.text(kMapLeft + kCellWidth * along, kMapTop - 10, map.names[row],
             {.size_px = 12, .anchor = Anchor::middle, .bold = true});
    svg.text(kMapLeft - 14, kMapTop + kCellHeight * along + 4.2, map.names[row],
             {.size_px = 12, .anchor = Anchor::end, .bold = true});
    for (std::size_t column = 0; column < count; ++column) draw_cell(svg, map, row, column);
  }
  for (std::size_t row = 0; row < count; ++row) {
    for (std::size_t column = 0; column < count; ++column) draw_selection_frame(svg, map, row, column);
  }
  if (map.simulated) draw_simulated_tag(svg, kMapLeft + width, kMapTop + height + 19);
  svg.text(kMapLeft, kMapTop + height + 19, map.caption, {.colour = colour::kFaintInk});
  return std::move(svg).finish();
}

}  // namespace gyrotherm::plot
