// SPDX-License-Identifier: Apache-2.0
/// Proximal point method for the dual, with steps solved by a semismooth Newton method. Its solution has exact zeros
/// and exact bounds.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/svr_problem.hpp"

namespace gyrotherm::svm {

/// Limits and initial step of the Newton method.
struct NewtonOptions {
  double relative_gap{};
  /// Desired gap, smaller than the required relative_gap. After relative_gap is reached, up to two more proximal
  /// centres are computed to reach `aim`. Not used if the start already meets relative_gap.
  double aim{};
  int max_steps{};
  /// σ/C of the first proximal step. Should be large if the start is close to the optimum.
  double first_weight{};
};

struct NewtonResult {
  SvrPoint point;  ///< best point found
  /// Response Kβ of the point. If the gap was reached, the response is computed from β directly and is not the result
  /// of updates from step to step.
  Eigen::VectorXd response;
  /// Relative duality gap for that response.
  double relative_gap{};
  int steps{};
};

/// Improves the feasible β `start` until the relative duality gap is reached or the step limit is exhausted.
///
/// A proximal step from the centre c minimises D(β) + ‖β − c‖²/(2σ) over the feasible β. With the residual r = y − Kβ −
/// b its solution is β_i(r) = clip(soft(c_i + σr_i, σε), −C, C), which is piecewise linear. One Newton step solves the
/// linear equations of the present pieces of all points,
/// (K_FF + I/σ)Δ + b1 = …,  Σβ = 0,
/// where F contains the points on a slope; all other points are exactly at 0 or ±C. The Newton step decreases the
/// convex function
/// Φ(β̃, b) = ½β̃ᵀKβ̃ + Σ_i max_β {β r_i − ε|β| − (β − c_i)²/(2σ)}
/// along a line search. σ grows after easy steps and shrinks after hard ones.
[[nodiscard]] NewtonResult solve_by_newton(const SvrProblem& problem, const Eigen::VectorXd& start,
                                           const NewtonOptions& options);

}  // namespace gyrotherm::svm
