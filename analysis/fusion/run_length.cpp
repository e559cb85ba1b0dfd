// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/run_length.hpp"

#include <Eigen/Dense>
#include <cassert>
#include <cmath>

#include "analysis/data/distributions.hpp"

namespace gyrotherm::fusion {
namespace {

struct Quadrature {
  Eigen::VectorXd nodes, weights;
};

/// Of Gauss and Legendre on 0 … `end`, by the eigenvalues of the Jacobi matrix (Golub and Welsch, Math. Comp. 23 (1969)
/// 221).
Quadrature gauss_legendre(Eigen::Index count, double end) {
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 1; i < count; ++i) {
    const auto n = static_cast<double>(i);
    jacobi(i, i - 1) = jacobi(i - 1, i) = n / std::sqrt(4 * n * n - 1);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(jacobi);
  return {.nodes = (0.5 * end * (solver.eigenvalues().array() + 1)).matrix(),
          .weights = end * solver.eigenvectors().row(0).transpose().cwiseAbs2()};
}

}  // namespace

double average_run_length(int dimension, double slack, double limit) {
  assert(dimension >= 1 && slack > 0 && limit > 0);
  constexpr double kNodesOfStep = 3, kFarthest = 12;  // standard deviations of the length, at least
  constexpr Eigen::Index kFewestNodes = 24;
  const auto count = kFewestNodes + static_cast<Eigen::Index>(kNodesOfStep * limit);
  const Quadrature quadrature = gauss_legendre(count, limit);
  const auto square = [](double x) { return x * x; };
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(count + 1, count + 1);  // I − P; the first state is 0
  for (Eigen::Index i = 0; i <= count; ++i) {
    const double noncentrality = i == 0 ? 0 : square(quadrature.nodes(i - 1));
    const double alarm = data::noncentral_chi_squared_exceeds(square(limit + slack), dimension, noncentrality);
    double away = alarm;
    for (Eigen::Index j = 0; j < count; ++j) {
      const double before = quadrature.nodes(j) + slack;
      if (std::abs(before - std::sqrt(noncentrality + dimension)) > kFarthest) continue;
      const double probability = quadrature.weights(j) * 2 * before *
                                 data::noncentral_chi_squared_density(square(before), dimension, noncentrality);
      left(i, j + 1) = -probability;
      away += probability;
    }
    left(i, 0) = away - 1;
    left(i, i) += 1;
  }
  return left.partialPivLu().solve(Eigen::VectorXd::Ones(count + 1))(0);
}

double limit_for_run_length(int dimension, double slack, double run_length) {
  constexpr double kLongest = 1e9, kTolerance = 1e-7;
  assert(run_length > 1 && run_length <= kLongest);
  const auto above = [&](double limit) {  // nearly straight
    return std::log(average_run_length(dimension, slack, limit) / run_length);
  };
  double low = kTolerance, of_low = above(low), high = 1, of_high = above(high);
  if (of_low >= 0) return low;
  while (of_high < 0) {
    low = high;
    of_low = of_high;
    high *= 2;
    of_high = above(high);
  }
  double best = high;
  int side = 0;  // of the end that was moved last
  for (double step = high - low; std::abs(step) > kTolerance * high;) {
    const double middle = high - of_high * (high - low) / (of_high - of_low), of_middle = above(middle);
    const int moved = of_middle < 0 ? -1 : 1;
    (moved < 0 ? low : high) = middle;
    (moved < 0 ? of_low : of_high) = of_middle;
    if (moved == side) (moved < 0 ? of_high : of_low) /= 2;
    side = moved;
    step = middle - best;
    best = middle;
  }
  return best;
}

}  // namespace gyrotherm::fusion
