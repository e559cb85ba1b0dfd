// SPDX-License-Identifier: Apache-2.0
/// Solves a symmetric positive definite sparse system for consecutive right-hand sides: conjugate gradients,
/// preconditioned by one V-cycle of algebraic multigrid (hypre's BoomerAMG) that is set up once. Runs in a single
/// process.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/result.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

struct ConjugateGradientsOptions {
  /// Limit of the residual's 2-norm, divided by the 2-norm of the right-hand side.
  double tolerance = 1e-10;
  /// Limit of the iterations. With the multigrid preconditioner some tens usually suffice.
  int most_iterations = 20'000;
};

/// The solver. Not thread-safe: use an instance on one thread at a time. The first instance of a process starts a
/// message-passing library for hypre (for this process only, without a daemon). Signal handlers and output streams do
/// not change.
class ConjugateGradients {
 public:
  struct Solution {
    Eigen::VectorXd x;
    int iterations{};
    double relative_residual{};
  };

  /// Creates a solver. The matrix contains both triangles and the diagonal of each row. Move it in: its memory is freed
  /// as early as possible. Fails with numeric if the preconditioner cannot be made.
  [[nodiscard]] static Result<ConjugateGradients> create(SparseMatrix matrix,
                                                         const ConjugateGradientsOptions& options = {});
  ~ConjugateGradients();
  ConjugateGradients(ConjugateGradients&&) noexcept;
  ConjugateGradients& operator=(ConjugateGradients&&) noexcept;

  /// Solves with the starting point `guess`. Fails with numeric if the tolerance is not reached.
  [[nodiscard]] Result<Solution> solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess);
  /// Solves with the starting point zero.
  [[nodiscard]] Result<Solution> solve(const Eigen::VectorXd& right);

  /// Applies one V-cycle from zero, which approximates the inverse of the matrix.
  [[nodiscard]] Eigen::VectorXd precondition(const Eigen::VectorXd& right);

  /// Replaces the matrix by a slightly different one of the same pattern. Keeps the first preconditioner.
  [[nodiscard]] Result<void> replace(SparseMatrix matrix);

 private:
  struct Parts;
  explicit ConjugateGradients(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace gyrotherm::thermal
