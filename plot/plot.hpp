/// The project's one plot module: panels of lines over a common x axis, written as SVG text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plot/axis.hpp"

namespace gyrotherm {

enum class Side { left, right };
enum class Marker { none, circle, square, diamond, triangle };

/// A named curve; a NaN breaks it.
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

/// A stretch of x with a name: the cycles of a program.
struct Stretch {
  std::string name;
  Range range;
};

struct Plot {
  std::string id;     ///< unique among the figures of one page: letters, digits, '-'
  std::string title;  ///< for screen readers
  AxisStyle x;
  std::vector<Panel> panels = {};       ///< one above the other
  std::vector<Stretch> stretches = {};  ///< divided by hairlines through all panels, named above the first
  bool simulated = false;               ///< then every panel says SIMULATED
  double width_px = 760;
};

/// The figure as one SVG document. Long curves are thinned to the least and the greatest value of each pixel column.
[[nodiscard]] std::string svg_of(const Plot& plot);

}  // namespace gyrotherm
