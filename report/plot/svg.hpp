// SPDX-License-Identifier: Apache-2.0
/// Writes SVG as text: the few shapes a figure needs, coordinates to a tenth of a pixel, so that equal figures are
/// equal bytes.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "report/plot/png.hpp"

namespace gyrotherm::plot {

/// How many colours the palette has. More could not be told apart by everybody: further lines differ in something else.
inline constexpr std::size_t kPaletteSize = 8;

/// One colour of the palette of Okabe and Ito (2008), without its yellow, which is too faint for a line; repeats after
/// kPaletteSize.
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

/// A shade from near white (0) to deep blue (1), as "#rrggbb"; outside 0…1 the nearer end.
[[nodiscard]] std::string shade(double fraction);

/// From cold (0) to hot (1): blue, pale yellow, red, after ColorBrewer's RdYlBu; outside 0…1 the nearer end.
[[nodiscard]] Rgb heat(double fraction);

/// Whether white text reads better than dark text on shade(fraction).
[[nodiscard]] bool shade_is_dark(double fraction);

/// Fixed decimals with a true minus sign; "–" for NaN, and never a negative zero: decimal(0.00214, 4) is "0.0021".
[[nodiscard]] std::string decimal(double value, int digits);

/// A bias or a residual in °/h, with four decimals as in the paper's tables.
[[nodiscard]] std::string format_bias(double deg_per_h);

/// A fraction in per cent with one decimal: percent(0.76404) is "76.4 %".
[[nodiscard]] std::string percent(double fraction);

/// Three significant digits: 1.23e-05 is "1.23 × 10⁻⁵" and 4.84 stays "4.84"; for certificates and tuned parameters.
[[nodiscard]] std::string significant(double value);

/// The label of a logarithmic axis: "0.02" and "500" near 1, "10⁻⁵" and "2 × 10⁻⁵" far from it.
[[nodiscard]] std::string digit_and_power(int digit, int exponent);

/// A value and its standard error, both to the second digit of the error: "0.00214 ± 0.00006". Without an error, as
/// significant() gives the value.
[[nodiscard]] std::string with_error(double value, double error);

/// A standard error alone, to its second digit: "0.000057".
[[nodiscard]] std::string format_error(double error);

/// A length of time in hours with two decimals: "18.67 h".
[[nodiscard]] std::string format_hours(double seconds);

/// Text made safe inside SVG and HTML, in elements and in attributes. Control characters, which XML forbids, are
/// dropped.
[[nodiscard]] std::string escaped(std::string_view text);

enum class Anchor { start, middle, end };

struct TextStyle {
  double size_px = 11;
  std::string colour = "#1d2733";
  Anchor anchor = Anchor::start;
  bool bold = false;
  double turned_deg = 0;  ///< counter-clockwise, about the text's own place
  double opacity = 1;
  std::string halo = {};  ///< colour around the letters, where they stand on lines; empty: none
};

struct Stroke {
  std::string colour;
  double width_px = 1;
  std::string dashes = {};  ///< "5 3", or empty for a solid line
};

/// A coordinate: one decimal at most, no negative zero, "12" for 12.0.
[[nodiscard]] std::string pixels(double value);

/// How wide a text is set, roughly: enough to lay out a legend without fonts.
[[nodiscard]] double text_width(std::string_view text, double size_px);

class SvgWriter {
 public:
  /// `title` is what a screen reader says.
  SvgWriter(double width_px, double height_px, std::string_view title);

  void rectangle(double x, double y, double width, double height, std::string_view fill, double opacity = 1);
  void frame(double x, double y, double width, double height, const Stroke& stroke);
  void line(double x1, double y1, double x2, double y2, const Stroke& stroke);
  void text(double x, double y, std::string_view content, const TextStyle& style);
  /// `data` is the path's own language ("M1 2L3 4"); `clip` names a region of clip_region(), or is empty.
  void path(std::string_view data, const Stroke& stroke, std::string_view clip = {});
  void shape(std::string_view data, std::string_view fill, std::string_view outline);
  /// A picture, stretched over the region; `png` is the file's bytes.
  void picture(double x, double y, double width, double height, std::string_view png);
  void clip_region(std::string_view id, double x, double y, double width, double height);

  /// Ends the figure; nothing may be drawn after.
  [[nodiscard]] std::string finish() &&;

 private:
  std::string out_;
};

/// The mark of a figure whose data come from a simulated rig: large and pale across the given region, to be drawn under
/// the data.
void draw_simulated_mark(SvgWriter& svg, double x, double y, double width, double height,
                         std::string_view mark = "SIMULATED");

/// The same in plain small letters that end at (x, y), where nothing covers them.
void draw_simulated_tag(SvgWriter& svg, double x, double y, std::string_view mark = "SIMULATED");

}  // namespace gyrotherm::plot
