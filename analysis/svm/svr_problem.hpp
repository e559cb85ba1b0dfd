// SPDX-License-Identifier: Apache-2.0
/// Training problem for the solvers, points of its dual, and the certificate of a point (errata 2.1 of the paper; the
/// dual is in svr.hpp).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/svm/kernel.hpp"

namespace gyrotherm::svm {

/// One training: references to a kernel and to targets, both of which must outlive it.
struct SvrProblem {
  Kernel& kernel;
  const Eigen::Ref<const Eigen::VectorXd>& y;
  double C;
  double epsilon;

  [[nodiscard]] Eigen::Index size() const { return y.size(); }
};

/// Point of the dual and an offset. It is feasible if Σβ = 0 to rounding (1e-12 C n) and |β_i| ≤ C.
struct SvrPoint {
  Eigen::VectorXd beta;
  double b{};
};

/// Duality gap and objective of a point, computed from its response Kβ.
struct Certificate {
  double relative_gap{};
  double objective{};  ///< D(β)
};

/// Adds Kβ to `sum`. Uses the cached columns of the kernel.
void add_response(const SvrProblem& problem, const Eigen::VectorXd& beta, Eigen::VectorXd& sum);

/// Makes Σβ = 0 by equal shifts of the `free` points within their bounds.
void spread_sum(const SvrProblem& problem, const std::vector<Eigen::Index>& free, Eigen::VectorXd& beta);

/// Returns the offset that minimises the primal value of β exactly. Σ max(0, |z_i − b| − ε), z = y − Kβ, is piecewise
/// linear in b with breakpoints z_i ± ε, and minimal between the n-th and the (n+1)-th. The middle of that interval is
/// returned.
[[nodiscard]] double best_offset(const SvrProblem& problem, const Eigen::VectorXd& response);

/// Computes the certificate of a point. The gap is defined at SvrSolution::relative_gap in svr.hpp; it is infinite if
/// the point is not feasible.
[[nodiscard]] Certificate certify(const SvrProblem& problem, const SvrPoint& point, const Eigen::VectorXd& response);

/// Computes the stopping measure of LIBSVM in n variables: max{u_i : β_i < C} − min{v_i : β_i > −C}. It is at most 0 at
/// an optimum.
[[nodiscard]] double kkt_violation(const SvrProblem& problem, const Eigen::VectorXd& beta,
                                   const Eigen::VectorXd& response);

}  // namespace gyrotherm::svm
