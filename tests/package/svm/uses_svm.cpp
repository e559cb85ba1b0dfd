// SPDX-License-Identifier: Apache-2.0
/// A program of a user of the library: trains an SVR on a parabola with the installed headers and libraries.
#include <cstdio>

#include "analysis/svm/svr.hpp"

int main() {
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(21, -1, 1);
  const auto solution = gyrotherm::svm::solve_svr(x, x.array().square(), {.C = 100, .sigma = 0.5, .epsilon = 0.01});
  if (!solution) return 1;
  std::printf("support vectors %d, gap %.1e\n", solution->support_vectors, solution->relative_gap);
  return solution->support_vectors > 2 && solution->relative_gap <= 1e-3 ? 0 : 1;
}
