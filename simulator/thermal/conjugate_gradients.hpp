// SPDX-License-Identifier: Apache-2.0
/// Solves a symmetric positive definite sparse system for one right-hand side after another: conjugate gradients,
/// preconditioned by one V-cycle of algebraic multigrid (hypre's BoomerAMG) that is set up once; a single process.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/result.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

struct ConjugateGradientsOptions {
  double tolerance = 1e-10;      ///< residual's 2-norm over the right-hand side's
  int most_iterations = 20'000;  ///< multigrid needs tens
};

/// Serial; one instance is used by one thread at a time. The first of a process starts a message-passing library for
/// hypre (for this process alone, no daemon) and leaves signal handlers and output streams as they were.
class ConjugateGradients {
 public:
  struct Solution {
    Eigen::VectorXd x;
    int iterations{};
    double relative_residual{};
  };

  /// Takes the matrix, both triangles, each row with its diagonal: move it in, its memory is freed as soon as it can
  /// be. Fails with numeric if the preconditioner cannot be made.
  [[nodiscard]] static Result<ConjugateGradients> set_up(SparseMatrix matrix,
                                                         const ConjugateGradientsOptions& options = {});
  ~ConjugateGradients();
  ConjugateGradients(ConjugateGradients&&) noexcept;
  ConjugateGradients& operator=(ConjugateGradients&&) noexcept;

  /// Begins at `guess`. Fails with numeric if the tolerance is not reached.
  [[nodiscard]] Result<Solution> solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess);
  /// Begins at zero.
  [[nodiscard]] Result<Solution> solve(const Eigen::VectorXd& right);

  /// One V-cycle alone, from zero: what stands for the matrix's inverse.
  [[nodiscard]] Eigen::VectorXd precondition(const Eigen::VectorXd& right);

  /// Goes on with a matrix of the same pattern and the preconditioner of the first: for a matrix little changed.
  [[nodiscard]] Result<void> replace(SparseMatrix matrix);

 private:
  struct Parts;
  explicit ConjugateGradients(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace gyrotherm::thermal
