// SPDX-License-Identifier: Apache-2.0
/// The gyro as a structured grid of 20-node bricks with grid lines on the faces of its boxes. A brick cut by a slanted
/// or round face contains each part with its share of the brick's volume. It also stores the direction across the face:
/// its conductivity is that of parallel parts along the face and of parts in series across the face (Farjadpour and
/// others, Opt. Lett. 31, 2006, 2972, for permittivity). Shares and directions are rounded to few values, so bricks
/// form classes with one material each. SI units.
///
/// In block mode bricks with less than a quarter of solid are dropped. Their content is assigned to a neighbour, whose
/// shares then add up to more than one. The film on a slanted face is distributed over the nearby brick faces so that
/// its total area is exact. The empty part of a remaining brick neither conducts along the face nor adds resistance
/// between solid and film.
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
/// Returns the target length of the brick edges: 4.6, 2.9 or 2.1 mm.
[[nodiscard]] double edge_mm(MeshSize size);

struct PartShare {
  GyroPart part{};
  double share{};
};
struct BrickClass {
  /// Empty for an empty brick.
  std::vector<PartShare> shares;
  /// Unit vector, level or upright; zero if no face cuts the brick.
  std::array<double, 3> across{};
};

/// Faces −x, +x, −y, +y, −z, +z.
inline constexpr int kBrickFaces = 6;

struct FilmFace {
  std::size_t brick{};
  int face{};
  /// True area divided by the area of the brick face.
  double factor = 1;
};

struct BrickIndex {
  int i, j, k;
};
/// Returns the position of brick (k·ny + j)·nx + i.
[[nodiscard]] inline BrickIndex brick_index(std::size_t brick, int nx, int ny) {
  const auto b = static_cast<int>(brick);
  return {b % nx, b / nx % ny, b / nx / ny};
}

/// The mesh. Brick (i, j, k) has the index (k·ny + j)·nx + i. Nodes are numbered along the doubled grid: point (I, J,
/// K) of (2nx + 1) × (2ny + 1) × (2nz + 1), with corners at even coordinates and midpoints of edges at points with one
/// odd coordinate.
struct GyroMesh {
  /// Grid lines, m.
  std::vector<double> x, y, z;
  /// The first class is empty.
  std::vector<BrickClass> classes;
  /// Class of each brick.
  std::vector<std::uint16_t> bricks;
  /// In the order of bricks; each face at most once.
  std::vector<FilmFace> film;
  /// Node of each point of the doubled grid; −1: none.
  std::vector<std::int32_t> nodes;
  std::size_t node_count{};
  std::size_t element_count{};

  [[nodiscard]] int nx() const { return static_cast<int>(x.size()) - 1; }
  [[nodiscard]] int ny() const { return static_cast<int>(y.size()) - 1; }
  [[nodiscard]] int nz() const { return static_cast<int>(z.size()) - 1; }
  [[nodiscard]] std::size_t brick(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * ny() + j) * nx() + i;
  }
  [[nodiscard]] BrickIndex brick_position(std::size_t brick) const { return brick_index(brick, nx(), ny()); }
  [[nodiscard]] std::size_t point(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * (2 * ny() + 1) + j) * (2 * nx() + 1) + i;
  }
};

/// Lengths of a brick's edges, m.
struct BrickEdges {
  double x{}, y{}, z{};
  [[nodiscard]] double volume() const { return x * y * z; }
  /// Returns the area of a face by its number.
  [[nodiscard]] double face_area(int face) const { return face < 2 ? y * z : face < 4 ? x * z : x * y; }
};
[[nodiscard]] inline BrickEdges edges(const GyroMesh& mesh, int i, int j, int k) {
  return {mesh.x[i + 1] - mesh.x[i], mesh.y[j + 1] - mesh.y[j], mesh.z[k + 1] - mesh.z[k]};
}

/// Returns the coordinate of a point of the doubled grid along one axis, m.
[[nodiscard]] inline double doubled_coordinate(const std::vector<double>& lines, int point) {
  return point % 2 == 0 ? lines[point / 2] : 0.5 * (lines[point / 2] + lines[point / 2 + 1]);
}

/// Calls visit(i, j, k, class) for every brick, including empty ones, in the order of their indices.
template <class Visit>
void each_brick(const GyroMesh& mesh, Visit visit) {
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i) visit(i, j, k, mesh.classes[mesh.bricks[mesh.brick(i, j, k)]]);
}

/// Calls visit(node, I, J, K) for every node in the order of their numbers. (I, J, K) is its point of the doubled grid.
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

/// Numbers the nodes and counts the elements of a mesh with complete lines, classes and bricks.
void number_nodes(GyroMesh& mesh);

/// Returns the volume of a part in the mesh, m³.
[[nodiscard]] double part_volume(const GyroMesh& mesh, GyroPart part);

/// Returns the share of a part in a brick class.
[[nodiscard]] double part_share(const BrickClass& brick, GyroPart part);
/// Returns the part with the largest share of a non-empty brick.
[[nodiscard]] GyroPart main_part(const BrickClass& brick);

// Files for other programs (mesh_files.cpp): the steady problem for CalculiX, as a cross-check, and a field for
// ParaView.

struct CalculixOptions {
  double ambient_c = 20;
  /// For example the final coefficients of steady_state().
  ThermalCoefficients coefficients{};
  /// If empty, CalculiX uses its default solver.
  std::string solver = "ITERATIVE CHOLESKY";
};

/// Writes an input file of CalculiX. Elements are DC3D20, node n of the mesh has the number n + 1, and each class of
/// bricks is a material. SI units and °C. `ccx NAME` writes the temperatures to NAME.dat. The caller checks the stream
/// for errors.
void write_calculix_input(std::ostream& out, const GyroModel& model, const GyroMesh& mesh,
                          const CalculixOptions& options);

/// Writes a VTK XML unstructured grid, binary appended: points in m, quadratic bricks (type 25), the temperature T in
/// °C by point, and the number of each brick's main part (GyroPart) by cell. The caller checks the stream for errors.
void write_vtu(std::ostream& out, const GyroMesh& mesh, const Eigen::VectorXd& field_c);

}  // namespace gyrotherm::thermal
