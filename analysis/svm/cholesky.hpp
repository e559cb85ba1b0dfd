// SPDX-License-Identifier: Apache-2.0
/// Cholesky factorisation for a few thousand unknowns, several times faster than a portable build of Eigen's.
#pragma once

#include <Eigen/Core>

namespace gyrotherm::svm {

/// Replaces the lower triangle of the symmetric `a` by L with a = LLᵀ. The strict upper triangle is not read and may be
/// overwritten. Returns false if `a` is not positive definite in double precision; the contents of `a` are then
/// undefined.
[[nodiscard]] bool factor_cholesky(Eigen::Ref<Eigen::MatrixXd> a);

/// Solves LLᵀx = b for each column of `b` in place.
void solve_cholesky(const Eigen::Ref<const Eigen::MatrixXd>& factor, Eigen::Ref<Eigen::MatrixXd> b);

/// Subtracts a aᵀ from `c`. Only the lower triangle of `c` is valid afterwards.
void subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& a, Eigen::Ref<Eigen::MatrixXd> c);

/// Returns the diagonal of (LLᵀ)⁻¹. Costs as much as one factorisation.
[[nodiscard]] Eigen::VectorXd inverse_diagonal(const Eigen::Ref<const Eigen::MatrixXd>& factor);

/// Returns (LLᵀ)⁻¹. Only its lower triangle is valid. Costs as much as two factorisations.
[[nodiscard]] Eigen::MatrixXd inverse_lower(const Eigen::Ref<const Eigen::MatrixXd>& factor);

}  // namespace gyrotherm::svm
