/// Inner step of making a mesh in block mode: which bricks stay, and which film lies on their faces.
#pragma once

#include <vector>

#include "thermal/brick_shares.hpp"

namespace gyrotherm {

/// Drops the cut bricks of which less than half of the plan is solid; what they hold goes to the fullest of the four
/// neighbours beside them that stays. Volumes and plan areas keep their sums.
void consolidate(std::vector<BrickContents>& contents, const GridLines& lines);

/// The film on the block, its mirrors and what stands on it, by brick and face: level faces by the plan area of the
/// brick, flat upright faces where the wall lies, slanted walls spread over the brick faces near them. The hole's wall
/// carries none. Sums are the true areas.
[[nodiscard]] std::vector<FilmFace> block_film(const GyroParts& parts, const GridLines& lines,
                                               const std::vector<BrickContents>& contents);

}  // namespace gyrotherm
