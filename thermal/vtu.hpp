/// A field as a file for ParaView.
#pragma once

#include <Eigen/Core>
#include <iosfwd>

#include "thermal/mesh.hpp"

namespace gyrotherm {

/// VTK XML unstructured grid, binary appended: points in m, quadratic bricks (type 25), the temperature T in °C by
/// point and the number of each brick's main part (GyroPart) by cell. Failure is the stream's to tell.
void write_vtu(std::ostream& out, const GyroMesh& mesh, const Eigen::VectorXd& field_c);

}  // namespace gyrotherm
