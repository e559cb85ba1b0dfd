// SPDX-License-Identifier: Apache-2.0
/// Derivatives of the held-out error of an ε-SVR with respect to its parameters (Keerthi, Sindhwani, Chapelle, NIPS
/// 2006).
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr.hpp"

namespace gyrotherm::bench {

/// log2 of C, σ and ε.
using Position = Eigen::Vector3d;
[[nodiscard]] svm::SvrParameters parameters_at(const Position& position);

/// Training samples and held-out samples in the same coordinates, one per row.
struct SplitSamples {
  const svm::SampleMatrix& training;
  const svm::SampleMatrix& held_out;
  const Eigen::VectorXd& held_out_y;
};

struct SquaredError {
  double sum{};
  Position slope = Position::Zero();  ///< slope of the sum
};

/// Computes the sum of the squared errors of a solution on the held-out samples, and its slope.
///
/// Let F be the points with 0 < |β| < C and B those with |β| = C, s the signs of β, and r the held-out residuals. At
/// the optimum K_FF β_F + K_FB β_B + b = y_F − ε s_F and Σβ = 0. With the multipliers of K_FF λ + µ1 = 2 K_VFᵀ r and
/// Σλ = 2 Σr, the slope is 2 rᵀ(∂K_V β + K_VB ∂β_B) − λᵀ(∂K_F β + K_FB ∂β_B + s_F ∂ε) − µ Σ∂β_B. It is exact as long as
/// no point enters or leaves F and B. Without a point in F the change of b is neglected.
[[nodiscard]] SquaredError differentiate(const SplitSamples& samples, const svm::SvrSolution& solution,
                                         const svm::SvrParameters& parameters);

}  // namespace gyrotherm::bench
