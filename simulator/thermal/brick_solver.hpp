// SPDX-License-Identifier: Apache-2.0
/// Steady conduction in a mesh of bricks: conjugate gradients whose matrix is never stored (brick_operator.hpp),
/// preconditioned by two levels. The upper one smooths on all nodes, in single precision, by Chebyshev polynomials of
/// the fourth kind (Lottes, Optimal polynomial smoothers for multigrid V-cycles, Numer. Linear Algebra Appl. 30, 2023,
/// e2518); the lower one is the grid's 8-node bricks, for which one V-cycle of algebraic multigrid stands.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/result.hpp"
#include "simulator/thermal/brick_operator.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

struct BrickSolverOptions {
  double tolerance = 1e-9;     ///< residual's 2-norm over the right-hand side's
  int most_iterations = 1000;  ///< two levels need tens
};

/// Serial; one instance is used by one thread at a time. The same on any number of processors' cores.
class BrickSolver {
 public:
  struct Solution {
    Eigen::VectorXd x;  ///< by node
    int iterations{};
    double relative_residual{};
  };

  /// The mesh may go afterwards. Fails with numeric if the preconditioner cannot be made.
  [[nodiscard]] static Result<BrickSolver> set_up(const GyroModel& model, const GyroMesh& mesh,
                                                  const ThermalCoefficients& coefficients,
                                                  const BrickSolverOptions& options = {});
  ~BrickSolver();
  BrickSolver(BrickSolver&&) noexcept;
  BrickSolver& operator=(BrickSolver&&) noexcept;

  /// Begins at `guess`, both by node. Fails with numeric if the tolerance is not reached.
  [[nodiscard]] Result<Solution> solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess);

  /// Goes on with other coefficients of the same model and mesh, and the lower level of the first.
  void replace(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients);

 private:
  struct Parts;
  explicit BrickSolver(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// The lower level of BrickSolver: the 8-node bricks of the same grid, whose nodes are the corners. The prolongation P
/// gives each midpoint of an edge the mean of the edge's ends.
class CornerLevel final {
 public:
  /// `diagonal` is above 0 where the mesh has a node.
  CornerLevel(const BrickPlaces& places, const Eigen::VectorXf& diagonal);

  /// Returns Pᵀ K P, which equals the conduction of the 8-node bricks to rounding. Both triangles, sorted.
  [[nodiscard]] SparseMatrix matrix(const BrickPlaces& places, const BrickWeights<double>& weights) const;
  /// Returns Pᵀ field, by corner.
  [[nodiscard]] Eigen::VectorXd down(const BrickPlaces& places, const Eigen::VectorXf& field) const;
  /// Sets field ← P corners, and 0 where there is no node.
  void up(const BrickPlaces& places, const Eigen::VectorXd& corners, Eigen::VectorXf& field) const;

 private:
  std::vector<std::int32_t> number_;  ///< corner at a place; −1: none
  std::vector<std::int32_t> place_;   ///< by corner
  std::vector<bool> has_node_;        ///< by place
};

}  // namespace gyrotherm::thermal
