// SPDX-License-Identifier: Apache-2.0
/// Without hypre: Eigen's conjugate gradients with the diagonal as preconditioner.
#include <fmt/format.h>

#include <Eigen/IterativeLinearSolvers>
#include <utility>

#include "thermal/conjugate_gradients.hpp"

namespace gyrotherm::thermal {

struct ConjugateGradients::Parts {
  SparseMatrix matrix;
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper> solver;
};

Result<ConjugateGradients> ConjugateGradients::set_up(SparseMatrix matrix, const ConjugateGradientsOptions& options) {
  auto parts = std::make_unique<Parts>();
  parts->matrix = std::move(matrix);
  parts->solver.setTolerance(options.tolerance);
  parts->solver.setMaxIterations(options.most_iterations);
  parts->solver.compute(parts->matrix);
  return ConjugateGradients(std::move(parts));
}

ConjugateGradients::ConjugateGradients(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
ConjugateGradients::~ConjugateGradients() = default;
ConjugateGradients::ConjugateGradients(ConjugateGradients&&) noexcept = default;
ConjugateGradients& ConjugateGradients::operator=(ConjugateGradients&&) noexcept = default;

auto ConjugateGradients::solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess) -> Result<Solution> {
  Solution solution;
  solution.x = parts_->solver.solveWithGuess(right, guess);
  solution.iterations = static_cast<int>(parts_->solver.iterations());
  solution.relative_residual = parts_->solver.error();
  if (parts_->solver.info() != Eigen::Success) {
    return failure(FaultKind::numeric, "conjugate gradients",
                   fmt::format("relative residual {:.1e} after {} iterations, expected at most {:.1e}",
                               solution.relative_residual, solution.iterations, parts_->solver.tolerance()));
  }
  return solution;
}

auto ConjugateGradients::solve(const Eigen::VectorXd& right) -> Result<Solution> {
  return solve(right, Eigen::VectorXd::Zero(right.size()));
}

Result<void> ConjugateGradients::replace(SparseMatrix matrix) {
  parts_->matrix = std::move(matrix);
  parts_->solver.compute(parts_->matrix);
  return {};
}

std::string_view preconditioner_name() { return "diagonal"; }

}  // namespace gyrotherm::thermal
