/// Inner part of assembly: a matrix of the grid made row by row, without triplets.
#pragma once

#include <vector>

#include "thermal/mesh.hpp"
#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm {

/// What a class of bricks weighs in a matrix: conductivities, W/(m·K), or a heat capacity by volume, J/(m³·K).
struct BrickWeight {
  double xx{};
  double yy{};
  double zz{};
  double xy{};
  double capacity{};
};

/// Sum over the bricks of their conduction and capacity matrices. Two nodes have an entry where they share a brick that
/// weighs anything. Symmetric to the last bit.
[[nodiscard]] SparseMatrix assemble_rows(const GyroMesh& mesh, const std::vector<BrickWeight>& weight_of_class);

/// Sum over the mesh's film faces, per unit of film: the matrix, W/K per W/(m²·K).
[[nodiscard]] SparseMatrix assemble_film(const GyroMesh& mesh);
/// Adds `film` times that to a matrix that has an entry for every two nodes of one brick.
void add_film(const GyroMesh& mesh, double film_w_per_m2_k, SparseMatrix& matrix);

}  // namespace gyrotherm
