/// Writes SVG as text: the few shapes a figure needs, coordinates to a tenth of a pixel, so that equal figures are
/// equal bytes.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm {

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
void draw_simulated_mark(SvgWriter& svg, double x, double y, double width, double height);

/// The same in plain small letters that end at (x, y), where nothing covers them.
void draw_simulated_tag(SvgWriter& svg, double x, double y);

}  // namespace gyrotherm
