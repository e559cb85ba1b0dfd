// SPDX-License-Identifier: Apache-2.0
/// Multiplies the conduction matrix of a mesh of bricks by a field without storing the matrix. In products of Legendre
/// polynomials the matrix of a brick is diagonal if its conductivity lies along the axes. A product then costs little
/// more than the conversion between nodes and polynomials: about 250 operations per brick instead of 800, and 4 stored
/// numbers per brick instead of 230.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// Positions of the values of a field for vector arithmetic: all corners of the grid, then the midpoints of the edges
/// along x, along y and along z, each with x running fastest. Positions without a node of the mesh are included; their
/// values are 0.
class FieldLayout final {
 public:
  explicit FieldLayout(const GyroMesh& mesh);

  [[nodiscard]] int nx() const { return nx_; }
  [[nodiscard]] int ny() const { return ny_; }
  [[nodiscard]] int nz() const { return nz_; }
  [[nodiscard]] Eigen::Index corner(int i, int j, int k) const {
    return (static_cast<Eigen::Index>(k) * (ny_ + 1) + j) * (nx_ + 1) + i;
  }
  [[nodiscard]] Eigen::Index x_edge(int i, int j, int k) const {
    return x_edges_ + (static_cast<Eigen::Index>(k) * (ny_ + 1) + j) * nx_ + i;
  }
  [[nodiscard]] Eigen::Index y_edge(int i, int j, int k) const {
    return y_edges_ + (static_cast<Eigen::Index>(k) * ny_ + j) * (nx_ + 1) + i;
  }
  [[nodiscard]] Eigen::Index z_edge(int i, int j, int k) const {
    return z_edges_ + (static_cast<Eigen::Index>(k) * (ny_ + 1) + j) * (nx_ + 1) + i;
  }
  /// Returns the position of a point of the doubled grid. At most one of its coordinates is odd.
  [[nodiscard]] Eigen::Index point_position(int I, int J, int K) const;
  /// Returns the position of a node of brick (i, j, k), in the element's order.
  [[nodiscard]] Eigen::Index node_position(int i, int j, int k, int node) const;
  [[nodiscard]] Eigen::Index corners() const { return x_edges_; }
  [[nodiscard]] Eigen::Index count() const { return count_; }
  /// Returns the length of a field's vector. Vector arithmetic may read and rewrite elements past the last position.
  [[nodiscard]] Eigen::Index padded_size() const { return count_ + kPadding; }

  /// Converts a field from the order of nodes to the order of positions, or back.
  [[nodiscard]] Eigen::VectorXd from_nodes(const Eigen::VectorXd& field) const;
  [[nodiscard]] Eigen::VectorXd to_nodes(const Eigen::VectorXd& field) const;

 private:
  static constexpr Eigen::Index kPadding = 32;
  int nx_, ny_, nz_;
  Eigen::Index x_edges_, y_edges_, z_edges_, count_;
  std::vector<std::int32_t> node_positions_;
};

/// Conductances of the bricks: for each brick k_dd·v/8·4/h_d² and k_xy·v/8·4/(h_x h_y), W/K, 0 for an empty one, and
/// the film faces. Rows of bricks along x are padded to whole vectors.
template <class Real>
struct BrickWeights {
  struct Face {
    std::array<std::int32_t, 8> positions;
    int face;
    Real film;  ///< W/K
  };
  /// Distance between rows of bricks, in elements.
  int stride{};
  std::vector<Real> x, y, z, xy;
  /// True for each row that contains a brick of non-zero k_xy.
  std::vector<bool> slanted;
  std::vector<Face> film;

  BrickWeights(const GyroModel& model, const GyroMesh& mesh, const FieldLayout& layout,
               const ThermalCoefficients& coefficients);
  [[nodiscard]] std::size_t row(int j, int k, int ny) const {
    return (static_cast<std::size_t>(k) * ny + j) * static_cast<std::size_t>(stride);
  }
};

/// Returns the 8 nodes of a brick's face in the element's order, the 4 corners first.
[[nodiscard]] std::array<int, 8> face_nodes(int face);

/// Calls visit(i, j, k, index of the brick's weights) for every brick, including empty ones.
template <class Real, class Visit>
void each_weighted_brick(const FieldLayout& layout, const BrickWeights<Real>& weights, Visit visit) {
  for (int k = 0; k < layout.nz(); ++k)
    for (int j = 0; j < layout.ny(); ++j)
      for (int i = 0; i < layout.nx(); ++i)
        visit(i, j, k, weights.row(j, k, layout.ny()) + static_cast<std::size_t>(i));
}

/// Computes product = K field. Both vectors have padded_size() elements. Elements past the last position must be
/// finite.
template <class Real>
void multiply(const FieldLayout& layout, const BrickWeights<Real>& weights, const Real* field, Real* product);

/// Returns the diagonal of K; 0 at positions without a node.
template <class Real>
[[nodiscard]] Eigen::Matrix<Real, Eigen::Dynamic, 1> diagonal(const FieldLayout& layout,
                                                              const BrickWeights<Real>& weights);

}  // namespace gyrotherm::thermal
