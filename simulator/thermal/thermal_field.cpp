// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/thermal_field.hpp"

#include <limits>

#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/hex20.hpp"

namespace gyrotherm::thermal {

ThermalField::ThermalField(const GyroModel& model, const GyroMesh& mesh, const Eigen::VectorXd& field_c)
    : model_(model), mesh_(mesh), field_c_(field_c), parts_(parts_of(model)) {}

double ThermalField::temperature_at(double x, double y, double z) const {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  constexpr double kEdge = 1e-9;  // m
  const auto off = [](const std::vector<double>& lines, double value) {
    return !(value >= lines.front() - kEdge && value <= lines.back() + kEdge);
  };
  if (off(mesh_.x, x) || off(mesh_.y, y) || off(mesh_.z, z)) return kNowhere;
  const auto at = locate(mesh_, x, y, z);
  if (mesh_.bricks[mesh_.brick(at.i, at.j, at.k)] == 0) return kNowhere;
  const auto nodes = nodes_of(mesh_, at.i, at.j, at.k);
  const auto shape = hex20_shape(at.xi, at.eta, at.zeta);
  double sum = 0;
  for (int n = 0; n < kHex20; ++n) sum += shape[n] * field_c_[nodes[n]];
  return sum;
}

std::optional<GyroPart> ThermalField::part_at(double x, double y, double z) const {
  return gyrotherm::thermal::part_at(model_, parts_, 1e3 * x, 1e3 * y, 1e3 * z);
}

}  // namespace gyrotherm::thermal
