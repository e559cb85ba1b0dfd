// SPDX-License-Identifier: Apache-2.0
/// The lower of the two levels on which steady conduction is solved (brick_solver.hpp): the 8-node bricks of the same
/// grid, whose nodes are the corners. P, the way up, gives each middle of an edge the mean of the edge's ends.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "simulator/thermal/brick_operator.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

class CornerLevel final {
 public:
  /// `diagonal`: above 0 where the mesh has a node.
  CornerLevel(const BrickPlaces& places, const Eigen::VectorXf& diagonal);

  /// Pᵀ K P, the conduction of the 8-node bricks to rounding; both triangles, sorted.
  [[nodiscard]] SparseMatrix matrix(const BrickPlaces& places, const BrickWeights<double>& weights) const;
  /// Pᵀ field, by corner.
  [[nodiscard]] Eigen::VectorXd down(const BrickPlaces& places, const Eigen::VectorXf& field) const;
  /// field ← P corners, 0 where there is no node.
  void up(const BrickPlaces& places, const Eigen::VectorXd& corners, Eigen::VectorXf& field) const;

 private:
  std::vector<std::int32_t> number_;  ///< of the corner at a place, −1: none
  std::vector<std::int32_t> place_;   ///< of a corner
  std::vector<bool> has_node_;        ///< by place
};

}  // namespace gyrotherm::thermal
