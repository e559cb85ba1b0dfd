/// Sequential minimal optimisation in n variables: two of them move at a time. Fast on easy trainings, and a good start
/// of the hard ones. Works on a copy of the kernel in single precision, so its result is to be certified by others.
#pragma once

#include "analysis/numerics/svr_problem.hpp"

namespace gyrotherm {

struct SmoResult {
  SvrPoint point;
  int iterations{};
  bool converged{};  ///< the violation in single precision fell below the tolerance
};

/// Starts at β = 0 and stops once the KKT violation is at most `tolerance`, or after `max_iterations`.
/// Working set: the most violating point i, and the j of the largest decrease to second order (Fan, Chen, Lin 2005).
/// The step continues through the kinks of ε|β|.
[[nodiscard]] SmoResult solve_by_smo(const SvrProblem& problem, double tolerance, int max_iterations);

}  // namespace gyrotherm
