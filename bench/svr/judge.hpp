// SPDX-License-Identifier: Apache-2.0
/// What a solution is worth, whoever made it: objective, duality gap and violation in double precision, from β and b
/// alone. The kernel is made anew from coordinate differences with the library's exp; a solver's own figure is never
/// reported.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr.hpp"

namespace gyrotherm::bench {

/// C, γ and ε of K_ij = exp(−γ‖x_i − x_j‖²), as LIBSVM counts them.
struct PeerParameters {
  double C{};
  double gamma{};
  double epsilon{};
};

/// σ of the same kernel: 1/√(2γ).
[[nodiscard]] svm::SvrParameters own_parameters(const PeerParameters& parameters);

struct Verdict {
  bool feasible{};     ///< −C ≤ β ≤ C and |Σβ| ≤ 1e-9·C·n
  double dual{};       ///< D = ½βᵀKβ − yᵀβ + ε‖β‖₁, lower is better
  double primal{};     ///< P = ½βᵀKβ + C Σ max(0, |y_i − (Kβ)_i − b| − ε)
  double gap{};        ///< (P + D)/|D|
  double violation{};  ///< LIBSVM's stopping measure in n variables
  int support_vectors{};
};

/// β as long as y; f(x) = Σ β_i K(x_i, x) + b.
[[nodiscard]] Verdict verdict_of(const svm::SampleMatrix& x, const Eigen::VectorXd& y, const PeerParameters& parameters,
                                 const Eigen::VectorXd& beta, double b);

/// f of each row of `at`, by a plain loop.
[[nodiscard]] Eigen::VectorXd plain_prediction(const svm::SampleMatrix& x, const Eigen::VectorXd& beta, double b,
                                               double gamma, const svm::SampleMatrix& at);

}  // namespace gyrotherm::bench
