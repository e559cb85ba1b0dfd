// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/run_length.hpp"

#include <Eigen/Dense>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/data/distributions.hpp"

namespace gyrotherm::assurance {
namespace {

/// P(X ≤ x) of the standard normal distribution.
double normal_probability(double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; }

}  // namespace

double individuals_run_length(double limit, double shift) {
  return 1 / (normal_probability(shift - limit) + normal_probability(-shift - limit));
}

double ewma_run_length(double lambda, double limit, double shift) {
  assert(lambda > 0 && lambda <= 1 && limit > 0);
  constexpr Eigen::Index kStates = 201;
  const double edge = limit * std::sqrt(lambda / (2 - lambda));
  const double width = 2 * edge / kStates;
  Eigen::MatrixXd leaves = Eigen::MatrixXd::Identity(kStates, kStates);
  for (Eigen::Index from = 0; from < kStates; ++from) {
    const double centre = -edge + (static_cast<double>(from) + 0.5) * width;
    const auto reaches = [&](double z) { return normal_probability((z - (1 - lambda) * centre) / lambda - shift); };
    for (Eigen::Index to = 0; to < kStates; ++to) {
      const double low = -edge + static_cast<double>(to) * width;
      leaves(from, to) -= reaches(low + width) - reaches(low);
    }
  }
  const Eigen::VectorXd lengths = leaves.partialPivLu().solve(Eigen::VectorXd::Ones(kStates));
  return lengths(kStates / 2);
}

double individuals_limit(double rate) {
  return data::coverage_factor(1 - rate, std::numeric_limits<double>::infinity());
}

double ewma_limit(double lambda, double rate) {
  assert(rate >= 1e-8 && rate < 0.5);
  double low = 0.1, high = 6.5;
  constexpr double kPrecision = 1e-4;
  while (high - low > kPrecision) {
    const double middle = (low + high) / 2;
    (ewma_run_length(lambda, middle) < 1 / rate ? low : high) = middle;
  }
  return high;
}

}  // namespace gyrotherm::assurance
