// SPDX-License-Identifier: Apache-2.0
/// Plots as SVG text: panels of lines over a common x axis, and arrays of shaded cells. All figures of the project use
/// this module.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace gyrotherm::plot {

struct Range {
  double low{};
  double high{};
};

struct Tick {
  double value{};
  std::string label;
};

/// Returns the range of the finite values; {0, 1} if there is none.
[[nodiscard]] Range value_range(const std::vector<double>& values);

/// Returns the smallest range that contains both.
[[nodiscard]] Range join_ranges(const Range& a, const Range& b);

/// Returns the tick step, 1, 2 or 5 times a power of ten, that divides the range into about `count` parts. An empty
/// range is treated as a range of width 1.
[[nodiscard]] double tick_step(const Range& range, int count);

/// Extends both ends of the range to the next tick, for about `count` ticks. ticks() with the same count then includes
/// both ends.
[[nodiscard]] Range round_out(const Range& range, int count);

/// Returns the ticks inside the range, ends included. Each label has as many decimals as the step requires.
[[nodiscard]] std::vector<Tick> ticks(const Range& range, int count);

/// Returns the range of the finite values above 0, for a logarithmic axis; {1, 10} if there is none.
[[nodiscard]] Range find_positive_range(const std::vector<double>& values);

/// Extends both ends of a positive range to 1, 2 or 5 times a power of ten.
[[nodiscard]] Range round_out_logarithmically(const Range& range);

/// Returns a tick at each digit of each decade inside the range. Powers of ten have labels; 2 and 5 have labels if the
/// range is shorter than two decades.
[[nodiscard]] std::vector<Tick> logarithmic_ticks(const Range& range);

/// Maps values to pixels.
struct Scale {
  Range values;
  /// Positions of values.low and values.high.
  double from_px{};
  double to_px{};
  bool logarithmic = false;
  /// Returns the position of a value. On a logarithmic scale a value that is not positive is at the start of the range.
  [[nodiscard]] double operator()(double value) const;
};

struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// Divides the range of x into `columns` and keeps the minimum and maximum of y in each, in their order; spikes
/// therefore remain visible. Consecutive NaNs of y, which break the line, are reduced to one. Returns series of at most
/// two points per column unchanged. `x` must not decrease and must have the length of `y`.
[[nodiscard]] Points decimate(const std::vector<double>& x, const std::vector<double>& y, std::size_t columns);

/// Inserts a NaN in y at each gap of a line of cluster means, so no line is drawn across the gap. `x` contains the
/// start of each cluster, and `step` is the cluster length. The NaN has the x of the first missing cluster.
[[nodiscard]] Points break_at_gaps(const std::vector<double>& x, const std::vector<double>& y, double step);

enum class Side { left, right };
enum class Marker { none, circle, square, diamond, triangle };

/// A named curve. A NaN breaks it; an isolated point is drawn as a dot.
struct Curve {
  std::string name;  ///< legend entry; empty: none
  std::string colour;
  /// Points of the curve: equal lengths, x increasing.
  std::vector<double> x = {}, y = {};
  Side side = Side::left;
  double width_px = 1.2;
  bool dashed = false;
  /// Draws a staircase: each value is kept until the next point.
  bool steps = false;
  Marker marker = Marker::none;
  bool hollow = false;
  /// Half-length of the error bar at each y; empty for no error bars.
  std::vector<double> error = {};
  bool line = true;  ///< false: markers only
};

/// A shaded range of y on the left axis.
struct Band {
  std::string name;
  Range range;
};

/// A horizontal line on the left axis.
struct Rule {
  std::string name;
  double value{};
};

struct AxisStyle {
  std::string title;
  /// Absent: the range of the data, rounded outwards.
  std::optional<Range> range = {};
  /// Names at 0, 1, 2, … instead of numbers.
  std::vector<std::string> categories = {};
  std::string colour = "#1d2733";
  /// Logarithmic axis. Values that are not positive are not drawn.
  bool logarithmic = false;
};

struct Panel {
  std::string title;  ///< "(a) Before and after compensation"
  AxisStyle left;
  /// Present if a curve uses the right side.
  std::optional<AxisStyle> right;
  /// Later curves are drawn over earlier ones.
  std::vector<Curve> curves;
  std::vector<Band> bands;
  std::vector<Rule> rules;
  /// Height of the plotting area.
  double height_px = 230;
};

/// Returns a panel with curves on its left side.
[[nodiscard]] Panel make_panel(std::string title, std::string left_title, std::vector<Curve> curves, double height_px);

/// A named section of x, such as a cycle of a program.
struct Stretch {
  std::string name;
  Range range;
};

/// Language of the texts that a figure generates.
struct PlotLanguage {
  bool decimal_comma = false;  ///< decimal sign of the axes
  /// Mark of a figure with Plot::simulated. A document uses its own, such as "DRAFT · SIMULATED".
  std::string simulated = "SIMULATED";
};

struct Plot {
  /// Unique among the figures of a page: letters, digits, '-'.
  std::string id;
  std::string title;             ///< for screen readers
  std::string description = {};  ///< for screen readers; may be empty
  AxisStyle x;
  std::vector<Panel> panels = {};
  /// Drawn with thin separating lines through all panels and with names above the first panel.
  std::vector<Stretch> stretches = {};
  /// Draws the mark PlotLanguage::simulated across every panel.
  bool simulated = false;
  double width_px = 760;
  PlotLanguage language = {};
};

/// Returns the figure as an SVG document. Long curves are reduced to the minimum and maximum of each pixel column.
[[nodiscard]] std::string to_svg(const Plot& plot);

/// A square matrix of numbers between 0 and 1, drawn as shaded cells, such as Table 3 of the paper.
struct HeatMap {
  std::string title;  ///< for screen readers
  /// Names of rows and columns.
  std::vector<std::string> names;
  /// Matrix in the order of the names; NaN is shown as "–".
  std::vector<std::vector<double>> values;
  /// Cells with greater values are framed and bold.
  double threshold{};
  /// Text below the cells.
  std::string caption;
  bool simulated = false;
};

[[nodiscard]] std::string to_svg(const HeatMap& map);

}  // namespace gyrotherm::plot
