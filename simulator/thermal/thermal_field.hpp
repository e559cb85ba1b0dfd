// SPDX-License-Identifier: Apache-2.0
/// The temperature field of a gyro's mesh at any point.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "simulator/thermal/gyro_parts.hpp"
#include "simulator/thermal/mesh.hpp"

namespace gyrotherm::thermal {

/// Keeps references: model, mesh and field must outlive it. Coordinates in m, in the cabinet's axes.
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
