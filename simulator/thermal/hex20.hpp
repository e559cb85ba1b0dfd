// SPDX-License-Identifier: Apache-2.0
/// Sums the matrices of a ThermalSystem for any coefficients. The positions of their elements are found once.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

class AffineMatrix final {
 public:
  /// Finds the positions. `system` must outlive this; its matrices must be compressed with sorted columns.
  explicit AffineMatrix(const ThermalSystem& system);

  /// Returns capacity·C + conduction·(K₀ + Σ_m c_m K_m). The result is an internal matrix that the next call
  /// overwrites.
  const SparseMatrix& sum(double capacity, double conduction, const ThermalCoefficients& c);

 private:
  struct Part {
    const SparseMatrix* matrix;
    /// Position in the sum of each nonzero element of `matrix`.
    std::vector<int> positions;
  };
  void add(const Part& part, double factor);

  SparseMatrix sum_;
  std::array<Part, 2 + kThermalCoefficients> parts_;  ///< C, K₀, K_m
};

// The 20-node serendipity brick on [−1, 1]³ (Zienkiewicz and Taylor, The Finite Element Method, vol. 1, 5th ed.,
// section 8.11). Nodes are in the order of Abaqus and CalculiX: four corners below, four above, four mid-edge nodes
// below, four above, four on the upright edges.

inline constexpr int kHex20 = 20;

/// Positions on the doubled grid of a brick: 0, 1 or 2 along x, y, z.
inline constexpr std::array<std::array<int, 3>, kHex20> kHex20Positions{
    {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 0, 0}, {2, 1, 0},
     {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2}, {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}}};

using Hex20Vector = Eigen::Matrix<double, kHex20, 1>;
using Hex20Matrix = Eigen::Matrix<double, kHex20, kHex20>;

[[nodiscard]] Hex20Vector hex20_shape(double xi, double eta, double zeta);
/// Returns the derivatives of the shape functions with respect to ξ, η and ζ, one row each.
[[nodiscard]] Eigen::Matrix<double, 3, kHex20> hex20_slopes(double xi, double eta, double zeta);

/// Integrals over the reference brick by Gauss's rule with 3 × 3 × 3 points, over its faces with 3 × 3. For a brick
/// with edges h_x, h_y, h_z and volume v: conduction k·v/8·Σ_d 4/h_d²·slopes[d], capacity ρc·v/8·mass, load q·v/8·load;
/// film on a face of area A: h·A/4·face_mass and, per kelvin of ambient, h·A/4·face_load.
struct Hex20Integrals {
  std::array<Hex20Matrix, 3> slopes;
  /// Products of the slopes along x and y in both orders; conductivity k_xy contributes k_xy·v/8·4/(h_x h_y)·cross.
  Hex20Matrix cross;
  Hex20Matrix mass;
  Hex20Vector load;
  /// Faces −x, +x, −y, +y, −z, +z.
  std::array<Hex20Matrix, 6> face_mass;
  std::array<Hex20Vector, 6> face_load;
};
[[nodiscard]] const Hex20Integrals& hex20_integrals();

}  // namespace gyrotherm::thermal
