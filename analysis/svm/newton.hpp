// SPDX-License-Identifier: Apache-2.0
/// The proximal point method, each of whose steps is solved by a semismooth Newton method; and with it, exact zeros and
/// bounds.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr_problem.hpp"

namespace gyrotherm::svm {

/// How far the Newton method goes, and how it begins.
struct NewtonOptions {
  double relative_gap{};
  double aim{};  ///< a smaller gap, for which up to two centres are gone further if the start was not good enough
  int max_steps{};
  double first_weight{};  ///< σ/C of the first proximal step; large if the start is good
};

struct NewtonResult {
  SvrPoint point;  ///< the best that was met
  /// Kβ of it; where the gap was reached, made from β alone and not followed from step to step.
  Eigen::VectorXd response;
  double relative_gap{};  ///< by that response
  int steps{};
};

/// Goes on from the feasible β `start` until the relative duality gap is reached or the steps are used up.
///
/// A proximal step from the centre c minimises D(β) + ‖β − c‖²/(2σ) over the feasible β. With the residual
/// r = y − Kβ − b its solution is β_i(r) = clip(soft(c_i + σr_i, σε), −C, C), which is piecewise linear: one Newton
/// step solves the linear equations of the pieces that the points now lie on,
///   (K_FF + I/σ)Δ + b1 = …,  Σβ = 0,
/// where F holds the points on a slope; all others are at 0 or ±C exactly. The Newton step decreases the convex
/// function
///   Φ(β̃, b) = ½β̃ᵀKβ̃ + Σ_i max_β {β r_i − ε|β| − (β − c_i)²/(2σ)}
/// along a line search. σ grows while the steps are easy and shrinks when they are not.
[[nodiscard]] NewtonResult solve_by_newton(const SvrProblem& problem, const Eigen::VectorXd& start,
                                           const NewtonOptions& options);

}  // namespace gyrotherm::svm
