// SPDX-License-Identifier: Apache-2.0
/// Solves steady conduction in a mesh of bricks: conjugate gradients without a stored matrix (brick_operator.hpp) and a
/// two-level preconditioner. The upper level smooths on all nodes, in single precision, by Chebyshev polynomials of the
/// fourth kind (Lottes, Optimal polynomial smoothers for multigrid V-cycles, Numer. Linear Algebra Appl. 30, 2023,
/// e2518). The lower level is the grid's 8-node bricks, approximately solved by one V-cycle of algebraic multigrid.
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
  /// Limit of the residual's 2-norm, divided by the 2-norm of the right-hand side.
  double tolerance = 1e-9;
  /// Limit of the iterations. With the two-level preconditioner some tens usually suffice.
  int most_iterations = 1000;
};

/// The solver. Not thread-safe: use an instance on one thread at a time. Results do not depend on the number of cores.
class BrickSolver {
 public:
  struct Solution {
    /// Solution by node.
    Eigen::VectorXd x;
    int iterations{};
    double relative_residual{};
  };

  /// Creates a solver. The mesh is not needed afterwards. Fails with numeric if the preconditioner cannot be made.
  [[nodiscard]] static Result<BrickSolver> create(const GyroModel& model, const GyroMesh& mesh,
                                                  const ThermalCoefficients& coefficients,
                                                  const BrickSolverOptions& options = {});
  ~BrickSolver();
  BrickSolver(BrickSolver&&) noexcept;
  BrickSolver& operator=(BrickSolver&&) noexcept;

  /// Solves with the starting point `guess`, both vectors by node. Fails with numeric if the tolerance is not reached.
  [[nodiscard]] Result<Solution> solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess);

  /// Changes the coefficients; model and mesh must be the same as before. The lower level remains that of the first
  /// coefficients.
  void replace(const GyroModel& model, const GyroMesh& mesh, const ThermalCoefficients& coefficients);

 private:
  struct Parts;
  explicit BrickSolver(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// The lower level of BrickSolver: the 8-node bricks of the same grid; their nodes are the corners. The prolongation P
/// assigns each midpoint of an edge the mean of the edge's ends.
class CornerLevel final {
 public:
  /// Creates the level. `diagonal` must be above 0 at each position with a node of the mesh.
  CornerLevel(const FieldLayout& layout, const Eigen::VectorXf& diagonal);

  /// Returns Pᵀ K P, equal to the conduction of the 8-node bricks up to rounding. Both triangles, sorted.
  [[nodiscard]] SparseMatrix matrix(const FieldLayout& layout, const BrickWeights<double>& weights) const;
  /// Returns Pᵀ field, by corner.
  [[nodiscard]] Eigen::VectorXd restrict_to_corners(const FieldLayout& layout, const Eigen::VectorXf& field) const;
  /// Sets field ← P corners, and 0 at positions without a node.
  void prolongate(const FieldLayout& layout, const Eigen::VectorXd& corners, Eigen::VectorXf& field) const;

 private:
  /// Corner at a position; −1: none.
  std::vector<std::int32_t> number_;
  /// Position of each corner.
  std::vector<std::int32_t> position_;
  std::vector<bool> has_node_;
};

}  // namespace gyrotherm::thermal
