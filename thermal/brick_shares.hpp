/// Inner step of making a mesh: its grid lines, and what of which part each brick holds.
#pragma once

#include <array>
#include <vector>

#include "thermal/gyro_parts.hpp"
#include "thermal/mesh.hpp"

namespace gyrotherm {

/// Lines on the faces of all boxes, on flat faces, hole and hub; each interval is divided evenly into the nearest whole
/// number of pieces of `edge_mm`, at least one. mm.
struct GridLines {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> z;
};
[[nodiscard]] GridLines grid_lines(const GyroModel& model, const GyroParts& parts, double edge_mm);

/// A brick's contents, and how much of its plan is solid (from 0 to 1).
struct BrickContents {
  std::array<double, kGyroParts> share{};
  double plan_share{};
  std::array<double, 3> across{};  ///< some vector across the face that cuts it, zero: none
  bool whole = true;               ///< lies in one box, or in nothing that is cut
};

/// By brick index. The shares add up to 1 in full mode, to at most 1 in block mode.
[[nodiscard]] std::vector<BrickContents> brick_contents(const GyroModel& model, const GyroParts& parts,
                                                        const GridLines& lines);

}  // namespace gyrotherm
