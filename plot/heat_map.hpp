// SPDX-License-Identifier: Apache-2.0
/// A square array of numbers between 0 and 1 as shaded cells: the paper's Table 3.
#pragma once

#include <string>
#include <vector>

namespace gyrotherm::plot {

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
