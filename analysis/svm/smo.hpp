/// Sequential minimal optimisation in n variables: two of them move at a time. Fast on easy trainings, and a good start
/// of the hard ones. Works on a kernel in single precision, so its result is to be certified by others.
#pragma once

#include "analysis/svm/svr_problem.hpp"

namespace gyrotherm {

struct SmoResult {
  Eigen::VectorXd beta;
  int iterations{};
  bool converged{};  ///< the violation in single precision fell below the tolerance
};

/// Starts at β = 0 and stops once the KKT violation is at most `tolerance`, or after `most` iterations.
///
/// All points take part at first. A training that needs more than n iterations goes on in working sets whose rows fit a
/// second-level cache, where an iteration costs a fraction: each time the most violating points and those of the last
/// set that are free are optimised among themselves, and then the gradient of all points follows.
[[nodiscard]] SmoResult solve_by_smo(const SvrProblem& problem, double tolerance, int most);

}  // namespace gyrotherm
