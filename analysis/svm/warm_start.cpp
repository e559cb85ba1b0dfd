// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/warm_start.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "analysis/svm/tuning.hpp"

namespace gyrotherm::svm {
namespace {

// β within this relative distance of a bound is taken to be at the bound. The scaling of a start changes β by rounding
// errors.
constexpr double kAtBound = 1e-12;
// Tolerance of the sum in units of C n, stricter than the tolerance of certify().
constexpr double kStartSumTolerance = 1e-13;

using RowIndex = std::unordered_map<Eigen::Index, Eigen::Index>;

RowIndex rows_by_number(const std::vector<Eigen::Index>& numbers) {
  RowIndex rows;
  for (std::size_t i = 0; i < numbers.size(); ++i) rows.emplace(numbers[i], static_cast<Eigen::Index>(i));
  return rows;
}

}  // namespace

std::optional<FoldSeed> FoldSeed::between(const TuningFold& from, const TuningFold& to) {
  if (from.train_rows.empty() || to.train_rows.empty() || from.train_x.cols() != to.train_x.cols()) return {};
  const RowIndex from_rows = rows_by_number(from.train_rows), to_rows = rows_by_number(to.train_rows);
  FoldSeed seed;
  std::vector<Eigen::Index> fresh;
  for (std::size_t i = 0; i < to.train_rows.size(); ++i) {
    const auto same = from_rows.find(to.train_rows[i]);
    seed.shared_.push_back(same == from_rows.end() ? -1 : same->second);
    if (same == from_rows.end()) fresh.push_back(static_cast<Eigen::Index>(i));
  }
  std::vector<std::pair<double, Eigen::Index>> distances(fresh.size());
  for (std::size_t i = 0; i < from.train_rows.size(); ++i) {
    if (to_rows.contains(from.train_rows[i])) continue;
    RemovedRow removed{.row = static_cast<Eigen::Index>(i), .nearest_rows = {}};
    for (std::size_t k = 0; k < fresh.size(); ++k)
      distances[k] = {(to.train_x.row(fresh[k]) - from.train_x.row(removed.row)).squaredNorm(), fresh[k]};
    const auto count = std::min<std::ptrdiff_t>(kNeighbours, std::ssize(distances));
    std::partial_sort(distances.begin(), distances.begin() + count, distances.end());
    removed.nearest_rows.fill(-1);
    for (std::ptrdiff_t k = 0; k < count; ++k) removed.nearest_rows[k] = distances[k].second;
    seed.removed_.push_back(removed);
  }
  return seed;
}

SvrStart FoldSeed::start(const SvrStart& solved) const {
  SvrStart start{.beta = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(shared_.size())), .bound = solved.bound};
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    if (shared_[i] >= 0) start.beta[static_cast<Eigen::Index>(i)] = solved.beta[shared_[i]];
  }
  for (const RemovedRow& removed : removed_) {
    double remainder = solved.beta[removed.row];
    for (const Eigen::Index row : removed.nearest_rows) {
      if (remainder == 0 || row < 0) break;
      const double moved = std::clamp(start.beta[row] + remainder, -start.bound, start.bound) - start.beta[row];
      start.beta[row] += moved;
      remainder -= moved;
    }
  }
  return start;
}

std::optional<Eigen::VectorXd> feasible_start(const SvrProblem& problem, const SvrStart& start) {
  assert(start.beta.size() == problem.size() && start.bound > 0);
  Eigen::VectorXd beta = start.beta * (problem.C / start.bound);
  std::vector<Eigen::Index> free, inside;
  for (Eigen::Index i = 0; i < beta.size(); ++i) {
    if (std::abs(beta[i]) >= (1 - kAtBound) * problem.C) {
      beta[i] = std::copysign(problem.C, beta[i]);
      continue;
    }
    inside.push_back(i);
    if (beta[i] != 0) free.push_back(i);
  }
  const double tolerance = kStartSumTolerance * problem.C * static_cast<double>(problem.size());
  spread_sum(problem, free, beta);
  if (std::abs(beta.sum()) > tolerance) spread_sum(problem, inside, beta);
  if (std::abs(beta.sum()) > tolerance) return {};
  return beta;
}

double octaves_between(const SvrParameters& a, const SvrParameters& b) {
  return std::abs(std::log2(a.C / b.C)) + 2 * std::abs(std::log2(a.sigma / b.sigma));
}

}  // namespace gyrotherm::svm
