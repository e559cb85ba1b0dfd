// SPDX-License-Identifier: Apache-2.0
#include "plot/heat_map.hpp"

#include "plot/svg.hpp"

namespace gyrotherm::plot {
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
  svg.rectangle(x, y, kCellWidth, kCellHeight, diagonal ? "#eef0f3" : shade(value));
  svg.frame(x, y, kCellWidth, kCellHeight, {"#ffffff", 1.5, ""});
  svg.text(x + kCellWidth / 2, y + kCellHeight / 2 + 4.2, diagonal ? "0" : decimal(value, 3),
           {.size_px = 12,
            .colour = diagonal               ? colour::kFaintInk
                      : shade_is_dark(value) ? "#ffffff"
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

std::string svg_of(const HeatMap& map) {
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
