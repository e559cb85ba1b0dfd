/// CalculiX as the peer: its program on the identical mesh, as a child of this one.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/result.hpp"
#include "thermal/gyro_model.hpp"
#include "thermal/mesh.hpp"
#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm {

struct CalculixRun {
  Eigen::VectorXd field_c;  ///< by node of the mesh
  double user_s{};          ///< processor time of the child, one thread
  double peak_bytes{};
};

/// Runs `ccx` with one thread in `scratch`, which gets large files. Fails with numeric if it is not there, fails, or
/// leaves nodes out.
[[nodiscard]] Result<CalculixRun> run_calculix(const GyroModel& model, const GyroMesh& mesh,
                                               const ThermalCoefficients& coefficients, const std::string& solver,
                                               const std::string& scratch);

}  // namespace gyrotherm
