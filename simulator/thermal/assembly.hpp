// SPDX-License-Identifier: Apache-2.0
/// From a mesh to matrices, straight into compressed rows: sums over bricks of integrals made once (hex20.hpp). And
/// back: from the temperatures of the nodes to the field at any point.
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

/// Everything of the heat equation as thermal_system.hpp has it, 18 outputs included; of a part that the mesh lacks the
/// row is empty. About 1.8 kB per node.
[[nodiscard]] ThermalSystem assemble(const GyroModel& model, const GyroMesh& mesh);

/// C, J/K, consistent (a lumped one would have negative entries at the corners).
[[nodiscard]] SparseMatrix assemble_capacity(const GyroModel& model, const GyroMesh& mesh);
/// B₀, n × 6: a source lies evenly over the volume of its part.
[[nodiscard]] Eigen::MatrixXd assemble_inputs(const GyroMesh& mesh);
/// The ambient's column of B_film, m²: the film's area by nodes.
[[nodiscard]] Eigen::VectorXd assemble_film_ambient(const GyroMesh& mesh);
/// L, 18 × n.
[[nodiscard]] SparseMatrix assemble_outputs(const GyroModel& model, const GyroMesh& mesh);

/// Conductivity of a brick's class, W/(m·K), affine in the coefficients: Σ f k along the face that cuts it, across the
/// face 1/Σ(f/k), of which the tangent at 0.03 W/(m·K) of the air is taken.
struct Conductivity {
  double xx{}, yy{}, zz{}, xy{};
};
[[nodiscard]] Conductivity conductivity(const GyroModel& model, const BrickClass& brick,
                                        const ThermalCoefficients& coefficients);
/// Heat capacity by volume of a brick's class, J/(m³·K).
[[nodiscard]] double heat_capacity(const GyroModel& model, const BrickClass& brick);

/// The nodes of brick (i, j, k) in the element's order.
[[nodiscard]] std::array<std::int32_t, 20> nodes_of(const GyroMesh& mesh, int i, int j, int k);

/// A point in the mesh's axes, m: the brick it lies in and its place there, −1…1. On a face the lower brick is taken.
struct BrickPoint {
  int i{}, j{}, k{};
  double xi{}, eta{}, zeta{};
};
[[nodiscard]] BrickPoint locate(const GyroMesh& mesh, double x, double y, double z);

/// The temperature field of a gyro's mesh at any point. Keeps references: model, mesh and field must outlive it.
/// Coordinates in m, in the cabinet's axes.
class ThermalField {
 public:
  ThermalField(const GyroModel& model, const GyroMesh& mesh, const Eigen::VectorXd& field_c);

  /// Returns the temperature that the elements interpolate, °C; NaN outside the mesh.
  [[nodiscard]] double temperature_at(double x, double y, double z) const;

  /// Returns the part by its true shape, not by the bricks; nothing outside all parts.
  [[nodiscard]] std::optional<GyroPart> part_at(double x, double y, double z) const;

 private:
  const GyroModel& model_;
  const GyroMesh& mesh_;
  const Eigen::VectorXd& field_c_;
  GyroParts parts_;
};

}  // namespace gyrotherm::thermal
