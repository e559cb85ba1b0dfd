// SPDX-License-Identifier: Apache-2.0
/// Writes SVG shapes. Coordinates are rounded to 0.1 px, so the same figure always gives the same bytes.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/number_text.hpp"
#include "report/plot/png.hpp"

namespace gyrotherm::plot {

/// Number of colours in the palette. More colours would be hard to distinguish; further lines must differ in another
/// way.
inline constexpr std::size_t kPaletteSize = 8;

/// Returns a colour of the palette of Okabe and Ito (2008) without its yellow, which is too faint for a line. Repeats
/// after kPaletteSize.
[[nodiscard]] std::string palette(std::size_t index);

namespace colour {
inline constexpr const char* kSetPoint = "#c8401b";
inline constexpr const char* kTemperature = "#0072b2";
inline constexpr const char* kBias = "#00855f";
inline constexpr const char* kRaw = "#9aa1a9";
inline constexpr const char* kThreePoint = "#d55e00";
inline constexpr const char* kMultiPoint = "#0072b2";
inline constexpr const char* kMultiPointT = "#00855f";
inline constexpr const char* kInk = "#1d2733";
inline constexpr const char* kFaintInk = "#5b6673";
inline constexpr const char* kGrid = "#e3e7ec";
inline constexpr const char* kFineGrid = "#f1f3f6";
inline constexpr const char* kFloor = "#f1e3b8";
inline constexpr const char* kSimulated = "#a8371b";
}  // namespace colour

/// Returns a shade from near white (0) to deep blue (1) as "#rrggbb"; clamps values outside 0…1.
[[nodiscard]] std::string shade_colour(double fraction);

/// Returns a colour from cold (0) to hot (1): blue, pale yellow, red, after ColorBrewer's RdYlBu; clamps values outside
/// 0…1.
[[nodiscard]] Rgb heat_colour(double fraction);

/// Returns true if white text is easier to read than dark text on shade_colour(fraction).
[[nodiscard]] bool is_shade_dark(double fraction);

using gyrotherm::decimal, gyrotherm::format_error, gyrotherm::format_significant, gyrotherm::format_with_error;

/// Formats a bias or a residual in °/h with four decimals, as in the paper's tables.
[[nodiscard]] std::string format_bias(double deg_per_h);

/// Formats a fraction in per cent with one decimal: percent(0.76404) is "76.4 %".
[[nodiscard]] std::string percent(double fraction);

/// Returns the label of digit × 10^exponent on a logarithmic axis: "0.02" and "500" near 1, otherwise "2 × 10⁻⁵".
[[nodiscard]] std::string digit_and_power(int digit, int exponent);

/// Formats a duration in hours with two decimals: "18.67 h".
[[nodiscard]] std::string format_hours(double seconds);

/// Escapes text for elements and attributes of SVG and HTML. Removes control characters, which XML forbids.
[[nodiscard]] std::string escaped(std::string_view text);

enum class Anchor { start, middle, end };

struct TextStyle {
  double size_px = 11;
  std::string colour = "#1d2733";
  Anchor anchor = Anchor::start;
  bool bold = false;
  double turned_deg = 0;  ///< counter-clockwise around the text position
  double opacity = 1;
  /// Colour around the letters, for text on top of lines; empty for none.
  std::string halo = {};
};

struct Stroke {
  std::string colour;
  double width_px = 1;
  std::string dashes = {};  ///< "5 3"; empty: solid
};

/// Formats a coordinate: at most one decimal, no negative zero, "12" for 12.0.
[[nodiscard]] std::string pixels(double value);

/// Estimates the width of a text in pixels without font files; accurate enough for the layout of a legend.
[[nodiscard]] double text_width(std::string_view text, double size_px);

class SvgWriter {
 public:
  /// `title` is the text for screen readers.
  /// Begins a figure. Title and description are for screen readers; an empty description is omitted.
  SvgWriter(double width_px, double height_px, std::string_view title, std::string_view description = {});

  void rectangle(double x, double y, double width, double height, std::string_view fill, double opacity = 1);
  void frame(double x, double y, double width, double height, const Stroke& stroke);
  void line(double x1, double y1, double x2, double y2, const Stroke& stroke);
  void text(double x, double y, std::string_view content, const TextStyle& style);
  /// `data` is an SVG path ("M1 2L3 4"); `clip` names a region of clip_region(), or is empty.
  void path(std::string_view data, const Stroke& stroke, std::string_view clip = {});
  void shape(std::string_view data, std::string_view fill, std::string_view outline);
  /// Draws a picture stretched to the rectangle; `png` is a PNG file.
  void picture(double x, double y, double width, double height, std::string_view png);
  void clip_region(std::string_view id, double x, double y, double width, double height);

  /// Ends the figure. No other member may be called afterwards.
  [[nodiscard]] std::string finish() &&;

 private:
  std::string out_;
};

/// Draws a large, pale mark of simulated data across the region. Call it before you draw the data.
void draw_simulated_mark(SvgWriter& svg, double x, double y, double width, double height,
                         std::string_view mark = "SIMULATED");

/// Draws the mark of simulated data in small letters that end at (x, y), outside the data.
void draw_simulated_tag(SvgWriter& svg, double x, double y, std::string_view mark = "SIMULATED");
/// Returns the approximate width of this tag.
[[nodiscard]] double simulated_tag_width(std::string_view mark);

}  // namespace gyrotherm::plot
