// SPDX-License-Identifier: Apache-2.0
/// Lines of equal value through a sampled field.
#pragma once

#include <cstddef>
#include <vector>

namespace gyrotherm::plot {

/// Samples on a rectangular grid, row by row; NaN where there is no field.
struct SampledField {
  std::size_t columns{};
  std::size_t rows{};
  std::vector<double> values;  ///< rows × columns
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// A place between the samples: column 0.5 lies half way from the first to the second.
struct FieldPoint {
  double column{};
  double row{};
};

using Isotherm = std::vector<FieldPoint>;  ///< open, or closed by repeating its first point

/// All lines on which the field, linear along the grid's edges, equals `level`: marching squares, saddles decided by
/// the mean of the four corners. Lines end at the field's edge and where it is NaN.
[[nodiscard]] std::vector<Isotherm> isotherms(const SampledField& field, double level);

}  // namespace gyrotherm::plot
