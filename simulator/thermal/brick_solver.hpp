// SPDX-License-Identifier: Apache-2.0
/// Steady conduction in a mesh of bricks: conjugate gradients whose matrix is never stored (brick_operator.hpp),
/// preconditioned by two levels. The upper one smooths on all nodes, in single precision, by Chebyshev polynomials of
/// the fourth kind (Lottes, Optimal polynomial smoothers for multigrid V-cycles, Numer. Linear Algebra Appl. 30, 2023,
/// e2518); the lower one is the grid's 8-node bricks, for which one V-cycle of algebraic multigrid stands.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/result.hpp"
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

}  // namespace gyrotherm::thermal
