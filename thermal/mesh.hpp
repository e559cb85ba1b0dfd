// SPDX-License-Identifier: Apache-2.0
/// The gyro as a structured grid of 20-node bricks whose lines lie on the faces of its boxes. A brick that a slanted or
/// round face cuts takes each part by its share of the brick's volume, and keeps the direction across the face, so that
/// its conductivity can be that of parts beside each other along the face and one behind the other across it
/// (Farjadpour and others, Opt. Lett. 31, 2006, 2972, for permittivity). Shares and directions are rounded, so that
/// bricks fall into classes of one material each. SI.
///
/// Where the block stands alone, bricks of which less than half is solid are dropped; what they held goes to a
/// neighbour (its shares then add up to more than one), and the film on a slanted face is spread over the brick faces
/// near it in such a way that its area is the true one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "thermal/gyro_model.hpp"
#include "thermal/gyro_parts.hpp"

namespace gyrotherm::thermal {

enum class MeshSize { coarse, medium, fine };
inline constexpr std::array<std::string_view, 3> kMeshSizeNames{"coarse", "medium", "fine"};
/// Edge that a mesh aims at: 4.6, 2.9 and 2.1 mm.
[[nodiscard]] double edge_mm(MeshSize size);

struct PartShare {
  GyroPart part{};
  double share{};
};
struct BrickClass {
  std::vector<PartShare> shares;   ///< empty: nothing there
  std::array<double, 3> across{};  ///< unit vector, in the plan or upright; zero: no face cuts the brick
};

/// Faces −x, +x, −y, +y, −z, +z.
inline constexpr int kBrickFaces = 6;

struct FilmFace {
  std::size_t brick{};
  int face{};
  double factor = 1;  ///< true area over the brick face's
};

/// Brick (i, j, k) has the index (k·ny + j)·nx + i. Nodes are numbered along the doubled grid: point (I, J, K) of
/// (2nx + 1) × (2ny + 1) × (2nz + 1), corners at even places, middles of edges where one place is odd.
struct GyroMesh {
  std::vector<double> x;  ///< grid lines, m
  std::vector<double> y;
  std::vector<double> z;
  std::vector<BrickClass> classes;    ///< the first is empty
  std::vector<std::uint16_t> bricks;  ///< class of each
  std::vector<FilmFace> film;         ///< in the order of bricks; a face at most once
  std::vector<std::int32_t> nodes;    ///< number of each point of the doubled grid, −1: none
  std::size_t node_count{};
  std::size_t element_count{};

  [[nodiscard]] int nx() const { return static_cast<int>(x.size()) - 1; }
  [[nodiscard]] int ny() const { return static_cast<int>(y.size()) - 1; }
  [[nodiscard]] int nz() const { return static_cast<int>(z.size()) - 1; }
  [[nodiscard]] std::size_t brick(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * ny() + j) * nx() + i;
  }
  [[nodiscard]] std::size_t point(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * (2 * ny() + 1) + j) * (2 * nx() + 1) + i;
  }
};

/// Lengths of a brick's edges, m.
struct BrickEdges {
  double x{};
  double y{};
  double z{};
  [[nodiscard]] double volume() const { return x * y * z; }
  /// Of the face of that number.
  [[nodiscard]] double face_area(int face) const { return face < 2 ? y * z : face < 4 ? x * z : x * y; }
};
[[nodiscard]] inline BrickEdges edges(const GyroMesh& mesh, int i, int j, int k) {
  return {mesh.x[i + 1] - mesh.x[i], mesh.y[j + 1] - mesh.y[j], mesh.z[k + 1] - mesh.z[k]};
}

/// Position of a point of the doubled grid along one axis, m.
[[nodiscard]] inline double doubled(const std::vector<double>& lines, int place) {
  return place % 2 == 0 ? lines[place / 2] : 0.5 * (lines[place / 2] + lines[place / 2 + 1]);
}

[[nodiscard]] GyroMesh make_mesh(const GyroModel& model, MeshSize size);
[[nodiscard]] GyroMesh make_mesh(const GyroModel& model, double edge_mm);

/// Numbers the nodes and counts the elements of a mesh whose lines, classes and bricks stand.
void number_nodes(GyroMesh& mesh);

/// Volume of a part in the mesh, m³.
[[nodiscard]] double volume_of(const GyroMesh& mesh, GyroPart part);

/// Share of a part in a brick's class.
[[nodiscard]] double share_of(const BrickClass& brick, GyroPart part);

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

/// Drops the cut bricks of which less than half of the plan is solid; what they hold goes to the fullest of the four
/// neighbours beside them that stays. Volumes and plan areas keep their sums.
void consolidate(std::vector<BrickContents>& contents, const GridLines& lines);

/// The film on the block, its mirrors and what stands on it, by brick and face: level faces by the plan area of the
/// brick, flat upright faces where the wall lies, slanted walls spread over the brick faces near them. The hole's wall
/// carries none. Sums are the true areas.
[[nodiscard]] std::vector<FilmFace> block_film(const GyroParts& parts, const GridLines& lines,
                                               const std::vector<BrickContents>& contents);

}  // namespace gyrotherm::thermal
