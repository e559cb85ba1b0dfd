// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/svr_problem.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/svm/lanes.hpp"

namespace gyrotherm::svm {
namespace {

constexpr int kSummedAtOnce = 4;
constexpr double kSumTolerance = 1e-12;  // factor of C n
constexpr double kGapFloor = 1e-9;       // factor of C Σ|y_i − ȳ|

GYROTHERM_CLONES
void add_columns(const double* const* columns, const double* weights, Eigen::Index n, double* sum) {
  for (Eigen::Index i = 0; i < n; ++i) {
    sum[i] += weights[0] * columns[0][i] + weights[1] * columns[1][i] + weights[2] * columns[2][i] +
              weights[3] * columns[3][i];
  }
}

bool is_feasible_point(const SvrProblem& problem, const Eigen::VectorXd& beta) {
  const double sum_tolerance = kSumTolerance * problem.C * static_cast<double>(problem.size());
  return std::abs(beta.sum()) <= sum_tolerance && beta.lpNorm<Eigen::Infinity>() <= problem.C;
}

}  // namespace

void add_response(const SvrProblem& problem, const Eigen::VectorXd& beta, Eigen::VectorXd& sum) {
  std::array<const double*, kSummedAtOnce> columns{};
  std::array<double, kSummedAtOnce> weights{};
  int filled = 0;
  for (Eigen::Index i = 0; i < beta.size(); ++i) {
    if (beta[i] == 0) continue;
    columns[filled] = problem.kernel.column(i);
    weights[filled] = beta[i];
    if (++filled < kSummedAtOnce) continue;
    add_columns(columns.data(), weights.data(), sum.size(), sum.data());
    filled = 0;
  }
  if (filled == 0) return;
  std::fill(columns.begin() + filled, columns.end(), columns[0]);
  std::fill(weights.begin() + filled, weights.end(), 0.0);
  add_columns(columns.data(), weights.data(), sum.size(), sum.data());
}

void spread_sum(const SvrProblem& problem, const std::vector<Eigen::Index>& free, Eigen::VectorXd& beta) {
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses && !free.empty(); ++pass) {
    const double share = beta.sum() / static_cast<double>(free.size());
    for (const Eigen::Index i : free) beta[i] = std::clamp(beta[i] - share, -problem.C, problem.C);
  }
}

double best_offset(const SvrProblem& problem, const Eigen::VectorXd& response) {
  const Eigen::Index n = problem.size();
  std::vector<double> breakpoints(static_cast<std::size_t>(2 * n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const double z = problem.y[i] - response[i];
    breakpoints[2 * i] = z - problem.epsilon;
    breakpoints[2 * i + 1] = z + problem.epsilon;
  }
  const auto upper = breakpoints.begin() + n;
  std::nth_element(breakpoints.begin(), upper, breakpoints.end());
  const double lower = *std::max_element(breakpoints.begin(), upper);
  return lower + 0.5 * (*upper - lower);
}

Certificate certify(const SvrProblem& problem, const SvrPoint& point, const Eigen::VectorXd& response) {
  const double half_norm = 0.5 * point.beta.dot(response);
  const Eigen::ArrayXd residual = (problem.y - response).array() - point.b;
  const double loss = problem.C * (residual.abs() - problem.epsilon).max(0.0).sum();
  const double primal = half_norm + loss;
  const double dual = half_norm - problem.y.dot(point.beta) + problem.epsilon * point.beta.lpNorm<1>();
  const double constant_loss = problem.C * (problem.y.array() - problem.y.mean()).abs().sum();
  const double scale = std::max({std::abs(dual), kGapFloor * constant_loss, std::numeric_limits<double>::min()});
  const bool is_feasible = is_feasible_point(problem, point.beta);
  return {is_feasible ? (primal + dual) / scale : std::numeric_limits<double>::infinity(), dual};
}

double kkt_violation(const SvrProblem& problem, const Eigen::VectorXd& beta, const Eigen::VectorXd& response) {
  double highest = -std::numeric_limits<double>::infinity();
  double lowest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < problem.size(); ++i) {
    const double descent = problem.y[i] - response[i];
    if (beta[i] < problem.C) highest = std::max(highest, descent + (beta[i] >= 0 ? -problem.epsilon : problem.epsilon));
    if (beta[i] > -problem.C) lowest = std::min(lowest, descent + (beta[i] > 0 ? -problem.epsilon : problem.epsilon));
  }
  return highest - lowest;
}

}  // namespace gyrotherm::svm
