// SPDX-License-Identifier: Apache-2.0
#include "bench/svr/judge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace gyrotherm::bench {

svm::SvrParameters own_parameters(const PeerParameters& parameters) {
  return {.C = parameters.C, .sigma = 1 / std::sqrt(2 * parameters.gamma), .epsilon = parameters.epsilon};
}

Eigen::VectorXd plain_prediction(const svm::SampleMatrix& x, const Eigen::VectorXd& beta, double b, double gamma,
                                 const svm::SampleMatrix& at) {
  const std::vector<Eigen::Index> support = svm::support_rows(beta);
  Eigen::VectorXd out(at.rows());
  for (Eigen::Index r = 0; r < at.rows(); ++r) {
    double sum = 0;
    for (const Eigen::Index i : support) {
      double squared = 0;
      for (Eigen::Index k = 0; k < x.cols(); ++k) {
        const double difference = x(i, k) - at(r, k);
        squared += difference * difference;
      }
      sum += beta[i] * std::exp(-gamma * squared);
    }
    out[r] = sum + b;
  }
  return out;
}

Verdict assess_solution(const svm::SampleMatrix& x, const Eigen::VectorXd& y, const PeerParameters& parameters,
                        const Eigen::VectorXd& beta, double b) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double C = parameters.C;
  const double epsilon = parameters.epsilon;
  const Eigen::VectorXd product = plain_prediction(x, beta, 0, parameters.gamma, x);  // Kβ
  Verdict verdict;
  double loss = 0;
  double up = -kNone;
  double down = kNone;
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    const double slope = y[i] - product[i];  // −g_i
    loss += std::max(0.0, std::abs(slope - b) - epsilon);
    if (beta[i] < C) up = std::max(up, beta[i] >= 0 ? slope - epsilon : slope + epsilon);
    if (beta[i] > -C) down = std::min(down, beta[i] > 0 ? slope - epsilon : slope + epsilon);
    if (beta[i] != 0) ++verdict.support_vectors;
  }
  const double quadratic = 0.5 * beta.dot(product);
  const double rounding = 1e-9 * C * static_cast<double>(y.size());
  verdict.feasible = beta.allFinite() && beta.cwiseAbs().maxCoeff() <= C && std::abs(beta.sum()) <= rounding;
  verdict.dual = quadratic - y.dot(beta) + epsilon * beta.lpNorm<1>();
  verdict.primal = quadratic + C * loss;
  verdict.gap = (verdict.primal + verdict.dual) / std::abs(verdict.dual);
  verdict.violation = up - down;
  return verdict;
}

}  // namespace gyrotherm::bench
