// SPDX-License-Identifier: Apache-2.0
#include "bench/tuning/descent.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "analysis/svm/cholesky.hpp"

namespace gyrotherm::bench {
namespace {

const Position kLower(-2, -2, -8), kUpper(12, 3.5, -1);
/// Octaves of σ count twice, as in svm::octaves_between().
const Position kScale(1, 2, 1);

struct Descent {
  Position at;
  LogError error;
  DescentHistory history;
  double radius{};
  Eigen::Matrix3d curvature;
  int steps = 0;
  bool done = false;
};

double halton(int index, int base) {
  double digit = 1, value = 0;
  for (; index > 0; index /= base) value += (digit /= base) * (index % base);
  return value;
}

/// Damped BFGS update, which keeps the matrix positive definite (Nocedal, Wright 2006, procedure 18.2).
void update_curvature(Eigen::Matrix3d& curvature, const Eigen::Vector3d& step, const Eigen::Vector3d& change) {
  const Eigen::Vector3d expected = curvature * step;
  const double quadratic = step.dot(expected), measured = step.dot(change);
  const double part = measured >= 0.2 * quadratic ? 1 : 0.8 * quadratic / (quadratic - measured);
  const Eigen::Vector3d damped = part * change + (1 - part) * expected;
  curvature += damped * damped.transpose() / step.dot(damped) - expected * expected.transpose() / quadratic;
}

void take_step(Descent& descent, FoldErrors& errors, const DescentOptions& options) {
  const Eigen::Vector3d slope = descent.error.slope.cwiseQuotient(kScale), scaled = descent.at.cwiseProduct(kScale);
  if (descent.steps++ == 0)
    descent.curvature = Eigen::Matrix3d::Identity() * std::max(slope.norm() / descent.radius, 1e-6);
  const Eigen::Vector3d step =
      best_step(slope, descent.curvature, (kLower.cwiseProduct(kScale) - scaled).cwiseMax(-descent.radius),
                (kUpper.cwiseProduct(kScale) - scaled).cwiseMin(descent.radius));
  const double expected_gain = -(slope.dot(step) + 0.5 * step.dot(descent.curvature * step));
  descent.done = expected_gain < options.least_gain;
  if (descent.done) return;
  const Position next = (scaled + step).cwiseQuotient(kScale).cwiseMax(kLower).cwiseMin(kUpper);
  const auto error = errors.evaluate(next, descent.history);
  const double length = step.lpNorm<Eigen::Infinity>();
  const double gain = error ? descent.error.value - error->value : -1;
  if (error) update_curvature(descent.curvature, step, error->slope.cwiseQuotient(kScale) - slope);
  if (gain <= 0.25 * expected_gain)
    descent.radius = 0.4 * length;
  else if (gain > 0.7 * expected_gain && length > 0.8 * descent.radius)
    descent.radius *= 2;
  descent.done = descent.radius < options.least_radius_octaves;
  if (gain <= 0) return;
  descent.at = next;
  descent.error = *error;
}

std::vector<Descent> screen(FoldErrors& errors, const DescentOptions& options) {
  std::vector<Descent> descents;
  for (int k = 0; k < options.screened; ++k) {
    Descent descent{.at = {}, .error = {}, .history = {}, .radius = options.first_radius_octaves, .curvature = {}};
    const Position part(halton(k, 2), halton(k, 3), halton(k, 5));
    descent.at = k == 0 ? Position(std::log2(3.0), 0.5 * std::log2(0.5 * static_cast<double>(errors.dimensions())), -4)
                              .cwiseMax(kLower)
                              .cwiseMin(kUpper)
                        : Position(kLower + (kUpper - kLower).cwiseProduct(part));
    const auto error = errors.evaluate(descent.at, descent.history);
    if (!error) continue;
    descent.error = *error;
    descents.push_back(std::move(descent));
  }
  std::ranges::stable_sort(descents, {}, [](const Descent& descent) { return descent.error.value; });
  return descents;
}

}  // namespace

Eigen::Vector3d best_step(const Eigen::Vector3d& slope, const Eigen::Matrix3d& curvature, const Eigen::Vector3d& lower,
                          const Eigen::Vector3d& upper) {
  constexpr int kFaces = 27;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = 0;
  for (int face = 0; face < kFaces; ++face) {
    const std::array<int, 3> side = {face % 3, face / 3 % 3, face / 9};
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    std::vector<Eigen::Index> free;
    for (int k = 0; k < 3; ++k) {
      if (side[k] == 0) free.push_back(k);
      if (side[k] != 0) step[k] = side[k] == 1 ? lower[k] : upper[k];
    }
    if (!free.empty()) {
      Eigen::MatrixXd factor = curvature(free, free), inside = -(slope + curvature * step)(free);
      if (!svm::factor_cholesky(factor)) continue;
      svm::solve_cholesky(factor, inside);
      step(free) = inside.col(0);
      if ((step.array() < lower.array()).any() || (step.array() > upper.array()).any()) continue;
    }
    const double value = slope.dot(step) + 0.5 * step.dot(curvature * step);
    if (value >= least) continue;
    least = value;
    best = step;
  }
  return best;
}

DescentResult descend(FoldErrors& errors, const DescentOptions& options) {
  std::vector<Descent> descents = screen(errors, options);
  assert(!descents.empty());
  const auto count = std::min(descents.size(), static_cast<std::size_t>(options.descents));
  while (errors.evaluations() < options.most_evaluations) {
    Descent* next = nullptr;
    for (std::size_t k = 0; k < count; ++k)
      if (!descents[k].done && (next == nullptr || descents[k].steps < next->steps)) next = &descents[k];
    if (next == nullptr) break;
    take_step(*next, errors, options);
  }
  const auto best = std::ranges::min_element(descents, {}, [](const Descent& descent) { return descent.error.value; });
  return {best->at, best->error.value};
}

}  // namespace gyrotherm::bench
