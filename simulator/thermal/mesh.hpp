// SPDX-License-Identifier: Apache-2.0
/// The gyro as a structured grid of 20-node bricks whose lines lie on the faces of its boxes. A brick that a slanted or
/// round face cuts takes each part by its share of the brick's volume, and keeps the direction across the face, so that
/// its conductivity can be that of parts beside each other along the face and one behind the other across it
/// (Farjadpour and others, Opt. Lett. 31, 2006, 2972, for permittivity). Shares and directions are rounded, so that
/// bricks fall into classes of one material each. SI.
///
/// Where the block stands alone, bricks of which less than a quarter is solid are dropped; what they held goes to a
/// neighbour (its shares then add up to more than one), and the film on a slanted face is spread over the brick faces
/// near it in such a way that its area is the true one. What is empty of a brick that stays conducts nothing along the
/// face, and does not stand in the way across it, towards the film.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

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

struct BrickPlace {
  int i, j, k;
};
/// The place of brick (k·ny + j)·nx + i.
[[nodiscard]] inline BrickPlace place_of(std::size_t brick, int nx, int ny) {
  const auto b = static_cast<int>(brick);
  return {b % nx, b / nx % ny, b / nx / ny};
}

/// Brick (i, j, k) has the index (k·ny + j)·nx + i. Nodes are numbered along the doubled grid: point (I, J, K) of
/// (2nx + 1) × (2ny + 1) × (2nz + 1), corners at even places, middles of edges where one place is odd.
struct GyroMesh {
  std::vector<double> x, y, z;        ///< grid lines, m
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
  [[nodiscard]] BrickPlace place(std::size_t brick) const { return place_of(brick, nx(), ny()); }
  [[nodiscard]] std::size_t point(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * (2 * ny() + 1) + j) * (2 * nx() + 1) + i;
  }
};

/// Lengths of a brick's edges, m.
struct BrickEdges {
  double x{}, y{}, z{};
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

/// Calls visit(i, j, k, class) for every brick, empty ones too, in the order of their indices.
template <class Visit>
void each_brick(const GyroMesh& mesh, Visit visit) {
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i) visit(i, j, k, mesh.classes[mesh.bricks[mesh.brick(i, j, k)]]);
}

/// Calls visit(node, I, J, K) for every node, (I, J, K) its point of the doubled grid, in the order of their numbers.
template <class Visit>
void each_node(const GyroMesh& mesh, Visit visit) {
  std::size_t point = 0;
  for (int K = 0; K <= 2 * mesh.nz(); ++K)
    for (int J = 0; J <= 2 * mesh.ny(); ++J)
      for (int I = 0; I <= 2 * mesh.nx(); ++I, ++point)
        if (mesh.nodes[point] >= 0) visit(mesh.nodes[point], I, J, K);
}

[[nodiscard]] GyroMesh make_mesh(const GyroModel& model, MeshSize size);
[[nodiscard]] GyroMesh make_mesh(const GyroModel& model, double edge_mm);

/// Numbers the nodes and counts the elements of a mesh whose lines, classes and bricks stand.
void number_nodes(GyroMesh& mesh);

/// Volume of a part in the mesh, m³.
[[nodiscard]] double volume_of(const GyroMesh& mesh, GyroPart part);

/// Share of a part in a brick's class.
[[nodiscard]] double share_of(const BrickClass& brick, GyroPart part);
/// The part that fills most of a brick, which is not empty.
[[nodiscard]] GyroPart main_part(const BrickClass& brick);

// Files for other programs (mesh_files.cpp): the steady problem for CalculiX, for whoever wants to check it, and a
// field for ParaView.

struct CalculixOptions {
  double ambient_c = 20;
  ThermalCoefficients coefficients{};         ///< such as steady_state() ended with
  std::string solver = "ITERATIVE CHOLESKY";  ///< empty: its own choice
};

/// Elements DC3D20, node n of the mesh has the number n + 1; each class of bricks is a material. SI, °C. `ccx NAME`
/// writes the temperatures to NAME.dat. Failure is the stream's to tell.
void write_calculix_input(std::ostream& out, const GyroModel& model, const GyroMesh& mesh,
                          const CalculixOptions& options);

/// VTK XML unstructured grid, binary appended: points in m, quadratic bricks (type 25), the temperature T in °C by
/// point and the number of each brick's main part (GyroPart) by cell. Failure is the stream's to tell.
void write_vtu(std::ostream& out, const GyroMesh& mesh, const Eigen::VectorXd& field_c);

}  // namespace gyrotherm::thermal
