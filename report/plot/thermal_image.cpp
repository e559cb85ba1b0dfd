// SPDX-License-Identifier: Apache-2.0
#include "report/plot/thermal_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>

#include "report/plot/svg.hpp"

namespace gyrotherm::plot {
namespace {

constexpr Rgb kOutline{90, 98, 108};
constexpr Rgb kPaper{255, 255, 255};

bool is_on_border(const ThermalImage& image, std::size_t row, std::size_t column) {
  const std::size_t here = row * image.celsius.columns + column;
  const bool right = column + 1 < image.celsius.columns && image.parts[here] != image.parts[here + 1];
  const bool down = row + 1 < image.celsius.rows && image.parts[here] != image.parts[here + image.celsius.columns];
  return right || down;
}

constexpr double kWidth = 620;  // width of the plane, px
constexpr double kImageLeft = 58;
constexpr double kImageTop = 40;
constexpr double kImageFoot = 50;
constexpr double kBarGap = 22;
constexpr double kBarWidth = 16;
constexpr double kBarText = 56;
// Samples per row of the plane used to draw the isotherms.
constexpr std::size_t kLineSamples = 300;
// Shorter isotherms have no label, px.
constexpr double kShortestLabelled = 90;

/// Position of the plane on the page.
struct Frame {
  Scale x, y;
  double height_px{};
};

Frame make_frame(const ThermalImage& image) {
  const double height = kWidth * (image.y_mm.high - image.y_mm.low) / (image.x_mm.high - image.x_mm.low);
  return {{image.x_mm, kImageLeft, kImageLeft + kWidth}, {image.y_mm, kImageTop + height, kImageTop}, height};
}

/// Returns every `stride`-th sample of every `stride`-th row.
SampledField thin_field(const SampledField& field, std::size_t stride) {
  SampledField thin{(field.columns + stride - 1) / stride, (field.rows + stride - 1) / stride, {}};
  thin.values.reserve(thin.columns * thin.rows);
  for (std::size_t row = 0; row < field.rows; row += stride) {
    for (std::size_t column = 0; column < field.columns; column += stride) thin.values.push_back(field.at(row, column));
  }
  return thin;
}

struct Line {
  std::string data;  ///< SVG path
  double length_px{};
  double middle_x{}, middle_y{};
};

/// Conversion of sample positions to pixels of the page.
struct PictureGrid {
  double px_per_column{}, px_per_row{};
  /// Position of the first sample inside the plane.
  double first_px{};
};

Line make_line(const Isotherm& isotherm, const PictureGrid& grid) {
  Line line;
  double last_x = 0, last_y = 0;
  for (std::size_t k = 0; k < isotherm.size(); ++k) {
    const double x = kImageLeft + grid.first_px + isotherm[k].column * grid.px_per_column;
    const double y = kImageTop + grid.first_px + isotherm[k].row * grid.px_per_row;
    fmt::format_to(std::back_inserter(line.data), "{}{} {}", k == 0 ? "M" : "L", pixels(x), pixels(y));
    if (k > 0) line.length_px += std::hypot(x - last_x, y - last_y);
    if (k <= isotherm.size() / 3) line.middle_x = x, line.middle_y = y;
    last_x = x, last_y = y;
  }
  return line;
}

bool is_whole(double value) { return std::abs(value - std::round(value)) < 1e-9; }

void draw_lines(SvgWriter& svg, const ThermalImage& image, const Frame& frame) {
  const std::size_t stride = std::max<std::size_t>(1, image.celsius.columns / kLineSamples);
  const SampledField thin = thin_field(image.celsius, stride);
  const double px_per_sample = kWidth / static_cast<double>(image.celsius.columns);
  const double stride_px = px_per_sample * static_cast<double>(stride);
  const double aspect =
      frame.height_px / kWidth * static_cast<double>(image.celsius.columns) / static_cast<double>(image.celsius.rows);
  const PictureGrid grid{stride_px, stride_px * aspect, px_per_sample / 2};
  for (const double level : isotherm_levels(image)) {
    const double width = is_whole(level) ? 1 : 0.5;
    Line longest;
    for (const auto& isotherm : isotherms(thin, level)) {
      Line line = make_line(isotherm, grid);
      svg.path(line.data, {colour::kInk, width});
      if (line.length_px > longest.length_px) longest = std::move(line);
    }
    if (longest.length_px < kShortestLabelled || !is_whole(level)) continue;
    svg.text(longest.middle_x, longest.middle_y + 3, decimal(level, 0),
             {.size_px = 10, .anchor = Anchor::middle, .halo = "#ffffff"});
  }
}

void draw_thermometers(SvgWriter& svg, const ThermalImage& image, const Frame& frame) {
  for (const auto& mark : image.marks) {
    const double x = frame.x(mark.x_mm), y = frame.y(mark.y_mm);
    svg.frame(x - 3.5, y - 3.5, 7, 7, {"#ffffff", 3});
    svg.frame(x - 3.5, y - 3.5, 7, 7, {colour::kInk, 1.6});
    svg.text(x, y - 9, mark.name, {.size_px = 14, .anchor = Anchor::middle, .bold = true, .halo = "#ffffff"});
    svg.text(x, y + 17, decimal(mark.celsius, 2), {.size_px = 10.5, .anchor = Anchor::middle, .halo = "#ffffff"});
  }
}

void draw_axes(SvgWriter& svg, const ThermalImage& image, const Frame& frame) {
  const double bottom = kImageTop + frame.height_px;
  svg.frame(kImageLeft, kImageTop, kWidth, frame.height_px, {colour::kInk, 1});
  for (const Tick& tick : ticks(image.x_mm, 8)) {
    svg.line(frame.x(tick.value), bottom, frame.x(tick.value), bottom + 4, {colour::kInk});
    svg.text(frame.x(tick.value), bottom + 17, tick.label, {.anchor = Anchor::middle});
  }
  for (const Tick& tick : ticks(image.y_mm, 8)) {
    svg.line(kImageLeft - 4, frame.y(tick.value), kImageLeft, frame.y(tick.value), {colour::kInk});
    svg.text(kImageLeft - 8, frame.y(tick.value) + 4, tick.label, {.anchor = Anchor::end});
  }
  svg.text(kImageLeft + kWidth / 2, bottom + 38, image.x_title, {.size_px = 12, .anchor = Anchor::middle});
  svg.text(16, kImageTop + frame.height_px / 2, image.y_title,
           {.size_px = 12, .anchor = Anchor::middle, .turned_deg = 90});
}

void draw_colour_bar(SvgWriter& svg, const ThermalImage& image, const Frame& frame) {
  constexpr std::size_t kSteps = 256;
  Picture bar{1, kSteps, {}};
  for (std::size_t k = 0; k < kSteps; ++k) {
    bar.points.push_back(heat_colour(1 - static_cast<double>(k) / static_cast<double>(kSteps - 1)));
  }
  const double left = kImageLeft + kWidth + kBarGap;
  svg.picture(left, kImageTop, kBarWidth, frame.height_px, to_png(bar));
  svg.frame(left, kImageTop, kBarWidth, frame.height_px, {colour::kInk, 1});
  const Scale scale{image.colours_c, kImageTop + frame.height_px, kImageTop};
  for (const Tick& tick : ticks(image.colours_c, 10)) {
    svg.line(left + kBarWidth, scale(tick.value), left + kBarWidth + 4, scale(tick.value), {colour::kInk});
    svg.text(left + kBarWidth + 7, scale(tick.value) + 4, tick.label, {});
  }
  svg.text(left + kBarWidth / 2, kImageTop - 10, "°C", {.size_px = 12, .anchor = Anchor::middle});
}

}  // namespace

bool can_be_drawn(const ThermalImage& image) {
  constexpr double kWidestPlane_mm = 1e5, kWidestField_k = 1000;
  const auto& field = image.celsius;
  const auto fits = [](const Range& range, double widest) {
    return range.high > range.low && range.high - range.low <= widest;
  };
  const Range found = value_range(field.values);
  return field.columns > 0 && field.columns <= 10'000 && field.rows > 0 && field.rows <= 10'000 &&
         field.values.size() == field.columns * field.rows && image.parts.size() == field.values.size() &&
         fits(image.x_mm, kWidestPlane_mm) && fits(image.y_mm, kWidestPlane_mm) &&
         fits(image.colours_c, kWidestField_k) && found.high - found.low <= kWidestField_k;
}

Picture colour_image(const ThermalImage& image) {
  const auto& field = image.celsius;
  assert(image.parts.size() == field.values.size());
  Picture picture{field.columns, field.rows, std::vector<Rgb>(field.values.size(), kPaper)};
  const double width_k = image.colours_c.high - image.colours_c.low;
  for (std::size_t k = 0; k < field.values.size(); ++k) {
    if (!std::isnan(field.values[k]))
      picture.points[k] = heat_colour((field.values[k] - image.colours_c.low) / width_k);
  }
  for (std::size_t row = 0; row < field.rows; ++row) {
    for (std::size_t column = 0; column < field.columns; ++column) {
      if (is_on_border(image, row, column)) picture.at(row, column) = kOutline;
    }
  }
  return picture;
}

std::vector<double> isotherm_levels(const ThermalImage& image) {
  const Range range = value_range(image.celsius.values);
  std::vector<double> levels;
  const double step = image.isotherm_step_k;
  for (double k = std::ceil(range.low / step); k * step <= range.high; ++k) levels.push_back(k * step);
  return levels;
}

std::string to_svg(const ThermalImage& image) {
  const Frame frame = make_frame(image);
  SvgWriter svg(kImageLeft + kWidth + kBarGap + kBarWidth + kBarText, kImageTop + frame.height_px + kImageFoot,
                image.simulated ? "SIMULATED – " + image.title : image.title);
  svg.text(kImageLeft, 22, image.title, {.size_px = 13, .bold = true});
  if (image.simulated) draw_simulated_tag(svg, kImageLeft + kWidth, 22);
  svg.picture(kImageLeft, kImageTop, kWidth, frame.height_px, to_png(colour_image(image)));
  draw_lines(svg, image, frame);
  draw_thermometers(svg, image, frame);
  draw_axes(svg, image, frame);
  draw_colour_bar(svg, image, frame);
  return std::move(svg).finish();
}

}  // namespace gyrotherm::plot
