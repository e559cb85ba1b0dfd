// SPDX-License-Identifier: Apache-2.0
/// The thermal image of the gyro: a plane through it with isotherms and thermometers, as in Figures 1 and 2 of the
/// paper.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/form.hpp"
#include "report/plot/plot.hpp"
#include "report/plot/png.hpp"

namespace gyrotherm::plot {

/// Samples on a rectangular grid; NaN outside the field.
struct SampledField {
  std::size_t columns{};
  std::size_t rows{};
  std::vector<double> values;  ///< row by row
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// A position between samples: column 0.5 is half-way from the first to the second.
struct FieldPoint {
  double column{};
  double row{};
};

/// An open line, or a closed one that repeats its first point.
using Isotherm = std::vector<FieldPoint>;

/// A thermometer on the plane.
struct ThermalMark {
  std::string name;
  double x_mm{}, y_mm{};
  double celsius{};
};

struct ThermalImage {
  std::string title;             ///< "Top face of the block, z = 52.5 mm"
  std::string x_title, y_title;  ///< "x, mm"
  /// Ranges that the samples cover; y points upwards.
  Range x_mm, y_mm;
  /// Top row first; NaN is drawn white.
  SampledField celsius;
  /// Index of the part that contains each sample; borders between parts are drawn.
  std::vector<int> parts;
  /// Temperatures of the first and the last colour.
  Range colours_c;
  double isotherm_step_k = 0.5;
  std::vector<ThermalMark> marks;
  bool simulated = false;
};

void describe(auto& form, Like<Range> auto& range) {
  form("low", range.low);
  form("high", range.high);
}

void describe(auto& form, Like<ThermalMark> auto& mark) {
  form("name", mark.name);
  form("x_mm", mark.x_mm);
  form("y_mm", mark.y_mm);
  form("celsius", mark.celsius);
}

/// Returns true if the image can be drawn: the number of samples matches the grid, and the ranges are not empty or
/// excessive.
[[nodiscard]] bool can_be_drawn(const ThermalImage& image);

void describe(auto& form, Like<ThermalImage> auto& image) {
  form("title", image.title);
  form("x_title", image.x_title);
  form("y_title", image.y_title);
  form("x_mm", image.x_mm);
  form("y_mm", image.y_mm);
  form("columns", image.celsius.columns);
  form("rows", image.celsius.rows);
  form("celsius", image.celsius.values);
  form("parts", image.parts);
  form("colours_c", image.colours_c);
  form("marks", image.marks);
  form("simulated", image.simulated);
  form.expect("celsius", can_be_drawn(image),
              "wrong number of values for the rows and columns, or a range that cannot be drawn");
}

/// Returns an SVG document with axes, a colour bar and labelled isotherms. The colours are a PNG inside it.
[[nodiscard]] std::string to_svg(const ThermalImage& image);

/// Returns the temperatures as colours, white for NaN, with the outlines of the parts.
[[nodiscard]] Picture colour_image(const ThermalImage& image);

/// Returns the temperatures of the isotherms, °C: multiples of the step within the range of the samples.
[[nodiscard]] std::vector<double> isotherm_levels(const ThermalImage& image);

/// Returns all lines on which the field equals `level`, interpolated linearly along the grid edges. Marching squares;
/// the mean of the four corners decides saddles. Lines end at the border of the field and at NaN.
[[nodiscard]] std::vector<Isotherm> isotherms(const SampledField& field, double level);

}  // namespace gyrotherm::plot
