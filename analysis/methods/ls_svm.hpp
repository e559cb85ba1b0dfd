// SPDX-License-Identifier: Apache-2.0
/// Least-squares support vector machine (Suykens et al. 2002); for ring laser gyros: Wei, Li and Long, Measurement 44
/// (2011) 1898, and Li et al., Opt. Express 23 (2015) 13320, refs. 15 and 24 of the paper.
///
/// Solves M [b; α] = [0; y] with M = [0 1ᵀ; 1 H], H = K + I/γ: Hη = 1, Hν = y, b = 1ᵀν/1ᵀη, α = ν − bη.
/// ŷ(z) = Σ α_i K(z_i, z) + b, K(z, z') = exp(−‖z − z'‖²/(2σ²)).
#pragma once

#include <vector>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// A machine, and what its solution leaves for other questions.
struct LsSvm {
  Eigen::MatrixXd factor;  ///< L of H = LLᵀ, lower triangle
  Eigen::VectorXd eta;     ///< H⁻¹1
  Eigen::VectorXd alpha;
  double b{};
};

/// Solves for a kernel matrix (symmetric, finite) and γ > 0. Fails with numeric if H is not positive definite in
/// double.
[[nodiscard]] Result<LsSvm> solve_ls_svm(const Eigen::Ref<const Eigen::MatrixXd>& kernel,
                                         const Eigen::Ref<const Eigen::VectorXd>& y, double gamma);

/// The diagonal d of M⁻¹ over the samples: e_i = α_i/d_i is the residual of a sample by the machine trained without it
/// (same kernel and γ; Cawley 2006; An, Liu and Venkatesh 2007), and n − Σd_i/γ the trace of the matrix from y to
/// fitted values.
[[nodiscard]] Eigen::VectorXd inverse_diagonal_of(const LsSvm& machine);

/// Chooses "gamma" and "sigma" by held-out error: from a grid over log2 γ = 2 … 18 and log2 σ = −½ … 5½ in steps of 4
/// and 1½, then around the best with half and with a quarter of these steps (quick: the grid alone). Folds are scaled
/// each by itself, so each is solved anew. Warns of a choice at the edge of the grid.
[[nodiscard]] Result<Choice> choose_ls_svm(std::span<const Fold> folds, const MethodOptions& options,
                                           const ProgressSink& progress);

/// The effective parameters are the trace; the particulars name the closed-form leave-one-out error.
[[nodiscard]] Result<Fit> fit_ls_svm(const FitInput& set, const HyperParameters& parameters,
                                     const MethodOptions& options);

}  // namespace gyrotherm::methods
