// SPDX-License-Identifier: Apache-2.0
/// One training as the solvers see it, a point of it, and the judge of both (errata 2.1 of the paper; svr.hpp has the
/// dual).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/svm/kernel.hpp"

namespace gyrotherm::svm {

/// One training: views of a kernel and of targets that outlive it.
struct SvrProblem {
  Kernel& kernel;
  const Eigen::Ref<const Eigen::VectorXd>& y;
  double C;
  double epsilon;

  [[nodiscard]] Eigen::Index size() const { return y.size(); }
};

/// A point of the dual and an offset; it is feasible if Σβ = 0 to rounding (1e-12 C n) and |β_i| ≤ C.
struct SvrPoint {
  Eigen::VectorXd beta;
  double b{};
};

/// What is known of a point from its response Kβ.
struct Certificate {
  double relative_gap{};
  double objective{};  ///< D(β)
};

/// Adds Kβ to `sum`, from columns that the kernel keeps.
void add_response(const SvrProblem& problem, const Eigen::VectorXd& beta, Eigen::VectorXd& sum);

/// Makes Σβ = 0 by equal shifts of the `free` points within their bounds.
void spread_sum(const SvrProblem& problem, const std::vector<Eigen::Index>& free, Eigen::VectorXd& beta);

/// The offset that minimises the primal value of β exactly: Σ max(0, |z_i − b| − ε), z = y − Kβ, is piecewise linear in
/// b with breakpoints z_i ± ε, and least from their n-th to their (n+1)-th; the middle of that interval.
[[nodiscard]] double best_offset(const SvrProblem& problem, const Eigen::VectorXd& response);

/// Judges a point: its gap is as defined at SvrSolution::relative_gap in svr.hpp, infinite if it is not feasible.
[[nodiscard]] Certificate certify(const SvrProblem& problem, const SvrPoint& point, const Eigen::VectorXd& response);

/// LIBSVM's stopping measure in n variables: max{u_i : β_i < C} − min{v_i : β_i > −C}; 0 or less at an optimum.
[[nodiscard]] double kkt_violation(const SvrProblem& problem, const Eigen::VectorXd& beta,
                                   const Eigen::VectorXd& response);

}  // namespace gyrotherm::svm
