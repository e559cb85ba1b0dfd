// SPDX-License-Identifier: Apache-2.0
/// The steady problem as an input file of CalculiX, on the identical mesh, for whoever wants to check it.
#pragma once

#include <Eigen/Core>
#include <iosfwd>
#include <string>

#include "thermal/gyro_model.hpp"
#include "thermal/mesh.hpp"
#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

struct CalculixOptions {
  double ambient_c = 20;
  ThermalCoefficients coefficients{};         ///< such as steady_state() ended with
  std::string solver = "ITERATIVE CHOLESKY";  ///< empty: its own choice
};

/// Elements DC3D20, node n of the mesh has the number n + 1; each class of bricks is a material. SI, °C. `ccx NAME`
/// writes the temperatures to NAME.dat. Failure is the stream's to tell.
void write_calculix_input(std::ostream& out, const GyroModel& model, const GyroMesh& mesh,
                          const CalculixOptions& options);

// A field as a file for ParaView.

/// VTK XML unstructured grid, binary appended: points in m, quadratic bricks (type 25), the temperature T in °C by
/// point and the number of each brick's main part (GyroPart) by cell. Failure is the stream's to tell.
void write_vtu(std::ostream& out, const GyroMesh& mesh, const Eigen::VectorXd& field_c);

}  // namespace gyrotherm::thermal
