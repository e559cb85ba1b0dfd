#include "thermal/thermal_field.hpp"

#include <limits>

#include "thermal/assembly.hpp"
#include "thermal/hex20.hpp"

namespace gyrotherm {

ThermalField::ThermalField(const GyroModel& model, const GyroMesh& mesh, const Eigen::VectorXd& field_c)
    : model_(model), mesh_(mesh), field_c_(field_c), parts_(parts_of(model)) {}

double ThermalField::temperature_at(double x, double y, double z) const {
  return gyrotherm::temperature_at(mesh_, field_c_, x, y, z);
}

std::optional<GyroPart> ThermalField::part_at(double x, double y, double z) const {
  return gyrotherm::part_at(model_, parts_, 1e3 * x, 1e3 * y, 1e3 * z);
}

double temperature_at(const GyroMesh& mesh, const Eigen::VectorXd& field_c, double x, double y, double z) {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  constexpr double kEdge = 1e-9;  // m
  const auto off = [](const std::vector<double>& lines, double value) {
    return !(value >= lines.front() - kEdge && value <= lines.back() + kEdge);
  };
  if (off(mesh.x, x) || off(mesh.y, y) || off(mesh.z, z)) return kNowhere;
  const auto at = locate(mesh, x, y, z);
  if (mesh.bricks[mesh.brick(at.i, at.j, at.k)] == 0) return kNowhere;
  const auto nodes = nodes_of(mesh, at.i, at.j, at.k);
  const auto shape = hex20_shape(at.xi, at.eta, at.zeta);
  double sum = 0;
  for (int n = 0; n < kHex20; ++n) sum += shape[n] * field_c[nodes[n]];
  return sum;
}

}  // namespace gyrotherm
