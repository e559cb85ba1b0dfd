#include "thermal/thermal_picture.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "plot/colour.hpp"

namespace gyrotherm {
namespace {

constexpr Rgb kOutline{90, 98, 108};
constexpr Rgb kLine{29, 39, 51};
constexpr Rgb kPaper{255, 255, 255};
constexpr int kLetterScale = 3;  // points per point of a letter

/// A…H, five points wide and seven high; the highest bit of a row is on the left.
constexpr std::array<std::array<std::uint8_t, 7>, 8> kLetters{{
    {0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001},
    {0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110},
    {0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110},
    {0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110},
    {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111},
    {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000},
    {0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01111},
    {0b10001, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001},
}};

/// A point that may lie outside the picture.
void put(Picture& picture, long row, long column, Rgb colour) {
  if (row < 0 || column < 0 || row >= static_cast<long>(picture.rows) || column >= static_cast<long>(picture.columns))
    return;
  picture.at(static_cast<std::size_t>(row), static_cast<std::size_t>(column)) = colour;
}

bool outlined(const ThermalImage& image, std::size_t row, std::size_t column) {
  const std::size_t here = row * image.celsius.columns + column;
  const bool right = column + 1 < image.celsius.columns && image.parts[here] != image.parts[here + 1];
  const bool down = row + 1 < image.celsius.rows && image.parts[here] != image.parts[here + image.celsius.columns];
  return right || down;
}

void draw_dot(Picture& picture, long row, long column) {
  for (long down = -5; down <= 5; ++down) {
    for (long along = -5; along <= 5; ++along) {
      const long distance2 = down * down + along * along;
      if (distance2 <= 27) put(picture, row + down, column + along, distance2 <= 12 ? kPaper : kLine);
    }
  }
}

/// The letter with a pale border, its top left corner at (row, column). Names that are no letter of A…H have only their
/// dot.
void draw_letter(Picture& picture, long row, long column, const std::string& name) {
  if (name.size() != 1 || name[0] < 'A' || name[0] > 'H') return;
  const auto& letter = kLetters[static_cast<std::size_t>(name[0] - 'A')];
  const auto inked = [&](long y, long x) {
    return y >= 0 && y < 7 && x >= 0 && x < 5 && (letter[static_cast<std::size_t>(y)] >> (4 - x) & 1) != 0;
  };
  for (long y = -kLetterScale; y < 8L * kLetterScale; ++y) {
    for (long x = -kLetterScale; x < 6L * kLetterScale; ++x) {
      const long from_y = (y + kLetterScale) / kLetterScale - 1, from_x = (x + kLetterScale) / kLetterScale - 1;
      put(picture, row + y, column + x, inked(from_y, from_x) ? kLine : kPaper);
    }
  }
}

}  // namespace

Picture coloured(const ThermalImage& image) {
  const auto& field = image.celsius;
  assert(image.parts.size() == field.values.size());
  Picture picture{field.columns, field.rows, std::vector<Rgb>(field.values.size(), kPaper)};
  const double width_k = image.colours_c.high - image.colours_c.low;
  for (std::size_t k = 0; k < field.values.size(); ++k) {
    if (!std::isnan(field.values[k])) picture.points[k] = heat((field.values[k] - image.colours_c.low) / width_k);
  }
  for (std::size_t row = 0; row < field.rows; ++row) {
    for (std::size_t column = 0; column < field.columns; ++column) {
      if (outlined(image, row, column)) picture.at(row, column) = kOutline;
    }
  }
  return picture;
}

std::vector<double> isotherm_levels(const ThermalImage& image) {
  const Range range = range_of(image.celsius.values);
  std::vector<double> levels;
  const double step = image.isotherm_step_k;
  for (double k = std::ceil(range.low / step); k * step <= range.high; ++k) levels.push_back(k * step);
  return levels;
}

void draw_isotherms(Picture& picture, const ThermalImage& image) {
  for (const double level : isotherm_levels(image)) {
    for (const auto& line : isotherms(image.celsius, level)) {
      for (const auto& point : line) put(picture, std::lround(point.row), std::lround(point.column), kLine);
    }
  }
}

void draw_marks(Picture& picture, const ThermalImage& image) {
  const auto column_of = [&](double x_mm) {
    return std::lround((x_mm - image.x_mm.low) / (image.x_mm.high - image.x_mm.low) *
                       static_cast<double>(picture.columns));
  };
  const auto row_of = [&](double y_mm) {
    return std::lround((image.y_mm.high - y_mm) / (image.y_mm.high - image.y_mm.low) *
                       static_cast<double>(picture.rows));
  };
  for (const auto& mark : image.marks) {
    const long row = row_of(mark.y_mm), column = column_of(mark.x_mm);
    draw_dot(picture, row, column);
    draw_letter(picture, row + 10, column - 5 * kLetterScale / 2, mark.name);
  }
}

}  // namespace gyrotherm
