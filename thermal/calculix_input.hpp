/// The steady problem as an input file of CalculiX, on the identical mesh, for whoever wants to check it.
#pragma once

#include <iosfwd>
#include <string>

#include "thermal/gyro_model.hpp"
#include "thermal/mesh.hpp"
#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm {

struct CalculixOptions {
  double ambient_c = 20;
  ThermalCoefficients coefficients{};         ///< such as steady_state() ended with
  std::string solver = "ITERATIVE CHOLESKY";  ///< empty: its own choice
};

/// Elements DC3D20, node n of the mesh has the number n + 1; each class of bricks is a material. SI, °C. `ccx NAME`
/// writes the temperatures to NAME.dat. Failure is the stream's to tell.
void write_calculix_input(std::ostream& out, const GyroModel& model, const GyroMesh& mesh,
                          const CalculixOptions& options);

}  // namespace gyrotherm
