// SPDX-License-Identifier: Apache-2.0
/// The project's one plot module: panels of lines over a common x axis, and arrays of shaded cells, as SVG text.
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

/// From the least to the greatest finite value; {0, 1} if there is none.
[[nodiscard]] Range range_of(const std::vector<double>& values);

/// The range that holds both.
[[nodiscard]] Range joined(const Range& a, const Range& b);

/// The step of 1, 2 or 5 times a power of ten that cuts the range into about `count` parts. A range without width
/// counts as 1.
[[nodiscard]] double tick_step(const Range& range, int count);

/// The range with both ends moved outwards to a tick of about `count` that ticks() then finds again.
[[nodiscard]] Range rounded_out(const Range& range, int count);

/// The ticks inside the range, ends included, each labelled with as many decimals as the step needs.
[[nodiscard]] std::vector<Tick> ticks(const Range& range, int count);

/// The same of a logarithmic axis. From the least to the greatest finite value above 0; {1, 10} if there is none.
[[nodiscard]] Range positive_range_of(const std::vector<double>& values);

/// Both ends, above 0, moved outwards to 1, 2 or 5 times a power of ten.
[[nodiscard]] Range logarithmically_rounded_out(const Range& range);

/// A tick at each digit of each decade inside the range. Powers of ten are labelled, and 2 and 5 too where the range is
/// shorter than two decades; the rest have no label.
[[nodiscard]] std::vector<Tick> logarithmic_ticks(const Range& range);

/// A map from values to pixels.
struct Scale {
  Range values;
  double from_px{};  ///< where values.low lies
  double to_px{};    ///< where values.high lies
  bool logarithmic = false;
  /// Of a logarithmic scale, values not above 0 lie where the range begins.
  [[nodiscard]] double operator()(double value) const;
};

struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// Cuts the range of x into `columns` and keeps the least and the greatest y of each, in their order, so that no spike
/// is lost. A NaN of y (a break in the line) is kept, once per run of them. Series of at most two points per column are
/// returned as they are. `x` must not fall; `x` and `y` have the same length.
[[nodiscard]] Points decimate(const std::vector<double>& x, const std::vector<double>& y, std::size_t columns);

/// A line of means of equal length, `step`, each at the x where it begins, with a NaN of y wherever one or more of them
/// are missing: what is not known is not drawn. The NaN lies where the first that is missing would begin.
[[nodiscard]] Points broken_at_gaps(const std::vector<double>& x, const std::vector<double>& y, double step);

enum class Side { left, right };
enum class Marker { none, circle, square, diamond, triangle };

/// A named curve; a NaN breaks it, and a point alone between two of them is a dot.
struct Curve {
  std::string name;  ///< in the legend; empty: not there
  std::string colour;
  std::vector<double> x = {}, y = {};  ///< of one length, x rising
  Side side = Side::left;
  double width_px = 1.2;
  bool dashed = false;
  bool steps = false;  ///< a value holds until the next point
  Marker marker = Marker::none;
  bool hollow = false;             ///< of the marker
  std::vector<double> error = {};  ///< of each y, drawn as a bar up and down; empty: none
  bool line = true;                ///< false: markers alone
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
  std::string title;                         ///< with its unit
  std::optional<Range> range = {};           ///< else from the data, rounded out
  std::vector<std::string> categories = {};  ///< x axis only: names for 0, 1, 2, … instead of numbers
  std::string colour = "#1d2733";
  bool logarithmic = false;  ///< values not above 0 are not drawn
};

struct Panel {
  std::string title;  ///< "(a) Before and after compensation"
  AxisStyle left;
  std::optional<AxisStyle> right;  ///< present if a curve is on that side
  std::vector<Curve> curves;       ///< later ones are drawn over earlier ones
  std::vector<Band> bands;
  std::vector<Rule> rules;
  double height_px = 230;  ///< of the plotting area
};

/// A panel of curves on its left side.
[[nodiscard]] Panel panel_of(std::string title, std::string left_title, std::vector<Curve> curves, double height_px);

/// A stretch of x with a name: the cycles of a program.
struct Stretch {
  std::string name;
  Range range;
};

/// How a figure writes what it says by itself.
struct PlotLanguage {
  bool decimal_comma = false;           ///< on its axes
  std::string simulated = "SIMULATED";  ///< the mark of simulated data
};

struct Plot {
  std::string id;     ///< unique among the figures of one page: letters, digits, '-'
  std::string title;  ///< for screen readers
  AxisStyle x;
  std::vector<Panel> panels = {};       ///< one above the other
  std::vector<Stretch> stretches = {};  ///< divided by hairlines through all panels, named above the first
  bool simulated = false;               ///< then every panel says SIMULATED
  double width_px = 760;
  PlotLanguage language = {};
};

/// The figure as one SVG document. Long curves are thinned to the least and the greatest value of each pixel column.
[[nodiscard]] std::string svg_of(const Plot& plot);

/// A square array of numbers between 0 and 1 as shaded cells: the paper's Table 3.
struct HeatMap {
  std::string title;                        ///< for screen readers
  std::vector<std::string> names;           ///< rows and columns
  std::vector<std::vector<double>> values;  ///< names × names, NaN is shown as "–"
  double threshold{};                       ///< values above it are framed and bold
  std::string caption;                      ///< below the cells
  bool simulated = false;
};

[[nodiscard]] std::string svg_of(const HeatMap& map);

}  // namespace gyrotherm::plot
