// SPDX-License-Identifier: Apache-2.0
/// Assembles the matrices of a mesh directly in compressed rows: sums over bricks of integrals that are computed once
/// (hex20.hpp). Also evaluates a field of node temperatures at any point.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/gyro_parts.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// Assembles the complete system of thermal_system.hpp with its 18 outputs. The rows of parts that are not in the mesh
/// are empty. Needs about 1.8 kB per node.
[[nodiscard]] ThermalSystem assemble(const GyroModel& model, const GyroMesh& mesh);

/// Returns the consistent capacity matrix C, J/K. A lumped matrix would have negative entries at the corners.
[[nodiscard]] SparseMatrix assemble_capacity(const GyroModel& model, const GyroMesh& mesh);
/// Returns B₀, n × 6. A source is distributed evenly over the volume of its part.
[[nodiscard]] Eigen::MatrixXd assemble_inputs(const GyroMesh& mesh);
/// Returns the ambient column of B_film, m²: the film area of each node.
[[nodiscard]] Eigen::VectorXd assemble_film_ambient(const GyroMesh& mesh);
/// Returns L, 18 × n.
[[nodiscard]] SparseMatrix assemble_outputs(const GyroModel& model, const GyroMesh& mesh);

/// Conductivity of a brick class, W/(m·K), affine in the coefficients: Σ f k along the face that cuts the brick and
/// 1/Σ(f/k) across it, where f is the share and k the conductivity of each part. The latter is linearised at an air
/// conductivity of 0.03 W/(m·K).
struct Conductivity {
  double xx{}, yy{}, zz{}, xy{};
};
[[nodiscard]] Conductivity conductivity(const GyroModel& model, const BrickClass& brick,
                                        const ThermalCoefficients& coefficients);
/// Returns the heat capacity by volume of a brick class, J/(m³·K).
[[nodiscard]] double heat_capacity(const GyroModel& model, const BrickClass& brick);

/// Returns the nodes of brick (i, j, k) in the element's order.
[[nodiscard]] std::array<std::int32_t, 20> brick_nodes(const GyroMesh& mesh, int i, int j, int k);

/// Location of a point in a mesh: its brick, and its coordinates within the brick, −1 … 1. A point on a face belongs to
/// the lower brick.
struct BrickPoint {
  int i{}, j{}, k{};
  double xi{}, eta{}, zeta{};
};
[[nodiscard]] BrickPoint locate(const GyroMesh& mesh, double x, double y, double z);

/// The temperature field of a gyro's mesh at any point. Keeps references: model, mesh and field must outlive it.
/// Coordinates are in m, in the cabinet's axes.
class ThermalField {
 public:
  ThermalField(const GyroModel& model, const GyroMesh& mesh, const Eigen::VectorXd& field_c);

  /// Returns the temperature interpolated by the elements, °C; NaN outside the mesh.
  [[nodiscard]] double temperature_at(double x, double y, double z) const;

  /// Returns the part at a point, or nothing outside all parts. Uses the true shapes of the parts instead of the
  /// bricks.
  [[nodiscard]] std::optional<GyroPart> part_at(double x, double y, double z) const;

 private:
  const GyroModel& model_;
  const GyroMesh& mesh_;
  const Eigen::VectorXd& field_c_;
  GyroParts parts_;
};

}  // namespace gyrotherm::thermal
