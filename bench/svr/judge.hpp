// SPDX-License-Identifier: Apache-2.0
/// Assesses the solution of any solver. Objective, duality gap and violation are computed in double precision from β
/// and b only, with a kernel from coordinate differences and std::exp. No value that a solver reports is used.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr.hpp"

namespace gyrotherm::bench {

/// C, γ and ε of K_ij = exp(−γ‖x_i − x_j‖²), as LIBSVM defines them.
struct PeerParameters {
  double C{};
  double gamma{};
  double epsilon{};
};

/// Returns the parameters of this project's solver for the same kernel: σ = 1/√(2γ).
[[nodiscard]] svm::SvrParameters own_parameters(const PeerParameters& parameters);

struct Verdict {
  bool feasible{};  ///< −C ≤ β ≤ C, |Σβ| ≤ 1e-9·C·n
  /// D = ½βᵀKβ − yᵀβ + ε‖β‖₁, lower is better.
  double dual{};
  /// P = ½βᵀKβ + C Σ max(0, |y_i − (Kβ)_i − b| − ε).
  double primal{};
  double gap{};        ///< (P + D)/|D|
  double violation{};  ///< LIBSVM's stopping measure
  int support_vectors{};
};

/// Assesses a solution. β has one element per target, and f(x) = Σ β_i K(x_i, x) + b.
[[nodiscard]] Verdict assess_solution(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                      const PeerParameters& parameters, const Eigen::VectorXd& beta, double b);

/// Computes f of each row of `at` by a plain loop.
[[nodiscard]] Eigen::VectorXd plain_prediction(const svm::SampleMatrix& x, const Eigen::VectorXd& beta, double b,
                                               double gamma, const svm::SampleMatrix& at);

}  // namespace gyrotherm::bench
