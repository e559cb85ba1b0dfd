/// A Cholesky factorisation for a few thousand unknowns, several times faster than a portable build of Eigen's.
#pragma once

#include <Eigen/Core>

namespace gyrotherm {

/// Replaces the lower triangle of the symmetric `a` by L with a = LLᵀ; the strict upper triangle is neither read nor
/// kept. False if `a` is not positive definite in double precision; `a` is then spoilt.
[[nodiscard]] bool factor_cholesky(Eigen::Ref<Eigen::MatrixXd> a);

/// Solves LLᵀx = b for each column of `b`, in place.
void solve_cholesky(const Eigen::Ref<const Eigen::MatrixXd>& factor, Eigen::Ref<Eigen::MatrixXd> b);

}  // namespace gyrotherm
