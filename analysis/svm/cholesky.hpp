// SPDX-License-Identifier: Apache-2.0
/// A Cholesky factorisation for a few thousand unknowns, several times faster than a portable build of Eigen's.
#pragma once

#include <Eigen/Core>

namespace gyrotherm::svm {

/// Replaces the lower triangle of the symmetric `a` by L with a = LLᵀ; the strict upper triangle is neither read nor
/// kept. False if `a` is not positive definite in double precision; `a` is then spoilt.
[[nodiscard]] bool factor_cholesky(Eigen::Ref<Eigen::MatrixXd> a);

/// Solves LLᵀx = b for each column of `b`, in place.
void solve_cholesky(const Eigen::Ref<const Eigen::MatrixXd>& factor, Eigen::Ref<Eigen::MatrixXd> b);

/// Sets c ← c − a aᵀ, of which only the lower triangle is kept.
void subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& a, Eigen::Ref<Eigen::MatrixXd> c);

/// The diagonal of (LLᵀ)⁻¹; it comes at the price of one more factorisation.
[[nodiscard]] Eigen::VectorXd inverse_diagonal(const Eigen::Ref<const Eigen::MatrixXd>& factor);

/// (LLᵀ)⁻¹, of which only the lower triangle is to be read; it comes at the price of two more factorisations.
[[nodiscard]] Eigen::MatrixXd inverse_lower(const Eigen::Ref<const Eigen::MatrixXd>& factor);

}  // namespace gyrotherm::svm
