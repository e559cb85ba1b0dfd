// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/change_detector.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <numbers>
#include <random>

#include "analysis/data/distributions.hpp"
#include "core/quantity.hpp"
#include "core/random.hpp"

namespace gyrotherm::fusion {
namespace {

struct Quadrature {
  Eigen::VectorXd nodes, weights;
};

/// Returns the Gauss-Legendre rule on 0 … `end`, from the eigenvalues of the Jacobi matrix (Golub and Welsch, Math.
/// Comp. 23 (1969) 221).
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

/// Returns the mean run length over random blocks of the healthy vectors, in steps; above `steps` if there was no
/// alarm.
double simulate_run_length(const Eigen::Ref<const Eigen::MatrixXd>& healthy, double slack, double limit, double steps) {
  constexpr std::uint64_t kSeed = 1;
  constexpr Eigen::Index kBlock = 36;  // one hour of 100 s
  std::mt19937_64 random(kSeed);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(healthy.rows());
  double taken = 0;
  int alarms = 0;
  while (taken < steps) {
    const Eigen::Index from = draw_index(healthy.cols(), random);
    for (Eigen::Index k = 0; k < kBlock; ++k) {
      ++taken;
      if (add_less_slack(sum, healthy.col((from + k) % healthy.cols()), slack) - slack <= limit) continue;
      ++alarms;
      sum.setZero();
    }
  }
  return alarms > 0 ? taken / alarms : 2 * steps;
}

struct Bracket {
  double low{}, high{};
};

/// Multiplies the upper end of a bracket that begins at `low` by `factor` until a rising function reaches `target`
/// there. Returns no value if the function is still below the target at `most`.
std::optional<Bracket> find_bracket(double low, double factor, double most, double target, auto rising) {
  assert(low > 0 && factor > 1);
  while (low < most) {
    const double high = std::min(factor * low, most);
    if (rising(high) >= target) return Bracket{low, high};
    low = high;
  }
  return std::nullopt;
}

/// Returns the greatest argument of the bracket at which a rising function is below `target`.
double find_crossing(Bracket bracket, double target, auto rising) {
  constexpr int kHalvings = 16;
  auto [low, high] = bracket;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (rising(middle) < target ? low : high) = middle;
  }
  return low;
}

}  // namespace

double average_run_length(int dimension, double slack, double limit) {
  assert(dimension >= 1 && slack > 0 && limit > 0);
  // Nodes further than kMaxDistance from the expected length are neglected. Its standard deviation is at most 1.
  constexpr double kNodesPerUnit = 3, kMaxDistance = 12;
  constexpr Eigen::Index kFewestNodes = 24;
  const auto count = kFewestNodes + static_cast<Eigen::Index>(kNodesPerUnit * limit);
  const Quadrature quadrature = gauss_legendre(count, limit);
  const auto square = [](double x) { return x * x; };
  // I − P; the first state is 0.
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(count + 1, count + 1);
  for (Eigen::Index i = 0; i <= count; ++i) {
    const double noncentrality = i == 0 ? 0 : square(quadrature.nodes(i - 1));
    const double alarm = data::noncentral_chi_squared_exceeds(square(limit + slack), dimension, noncentrality);
    double away = alarm;
    for (Eigen::Index j = 0; j < count; ++j) {
      const double before = quadrature.nodes(j) + slack;
      if (std::abs(before - std::sqrt(noncentrality + dimension)) > kMaxDistance) continue;
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
  constexpr double kMaxRunLength = 1e9, kTolerance = 1e-7;
  assert(run_length > 1 && run_length <= kMaxRunLength);
  const auto above = [&](double limit) {  // nearly linear in the limit
    return std::log(average_run_length(dimension, slack, limit) / run_length);
  };
  double low = kTolerance, at_low = above(low), high = 1, at_high = above(high);
  if (at_low >= 0) return low;
  while (at_high < 0) {
    low = high;
    at_low = at_high;
    high *= 2;
    at_high = above(high);
  }
  double best = high;
  // End of the interval that was moved last: −1 low, 1 high.
  int side = 0;
  for (double step = high - low; std::abs(step) > kTolerance * high;) {
    const double middle = high - at_high * (high - low) / (at_high - at_low), at_middle = above(middle);
    const int moved = at_middle < 0 ? -1 : 1;
    (moved < 0 ? low : high) = middle;
    (moved < 0 ? at_low : at_high) = at_middle;
    if (moved == side) (moved < 0 ? at_high : at_low) /= 2;
    side = moved;
    step = middle - best;
    best = middle;
  }
  return best;
}

std::optional<double> learn_sum_limit(const Eigen::Ref<const Eigen::MatrixXd>& healthy, double slack,
                                      double run_length) {
  assert(healthy.allFinite() && slack > 0);
  if (healthy.cols() < kFewestHealthy) return std::nullopt;
  constexpr double kSimulatedRuns = 400;
  const auto dimension = static_cast<int>(healthy.rows());
  const double white_limit = limit_for_run_length(dimension, slack, run_length);
  const double shown = std::min(run_length, static_cast<double>(healthy.cols()));
  const double least = limit_for_run_length(dimension, slack, shown);
  const auto simulated = [&](double limit) {
    return simulate_run_length(healthy, slack, limit, kSimulatedRuns * shown);
  };
  const auto bracket = find_bracket(least, 2, kMaxLimitFactor * least, shown, simulated);
  if (!bracket) return std::nullopt;
  const double drawn = find_crossing(*bracket, shown, simulated);
  if (drawn <= least) return white_limit;
  if (shown == run_length) return drawn;
  // The small steps avoid run lengths that are too long to be computed.
  const auto of_part = [&](double part) { return average_run_length(dimension, slack * part, drawn * part); };
  const auto parts = find_bracket(least / drawn, std::numbers::sqrt2, 1, shown, of_part);
  const double deviation = parts ? 1 / find_crossing(*parts, shown, of_part) : 1;
  return std::max(white_limit, deviation * limit_for_run_length(dimension, slack / deviation, run_length));
}

ChangeDetector::ChangeDetector(int dimension, double slack, double limit)
    : slack_(slack), limit_(limit), sum_(Eigen::VectorXd::Zero(dimension)) {
  constexpr double kMemoryFactor = 8, kMaxMemory = 1e6;
  recent_ = Eigen::MatrixXd::Zero(dimension,
                                  static_cast<Eigen::Index>(1 + std::min(kMemoryFactor * limit / slack, kMaxMemory)));
}

Result<ChangeDetector> ChangeDetector::make(const ChangeOptions& options) {
  const auto refuse = [](std::string what) {
    return failure(FaultKind::usage, "detection of changes", std::move(what));
  };
  if (options.dimension < 1)
    return refuse(fmt::format("vectors have the dimension {}, expected at least 1", options.dimension));
  if (!(options.shift > 0 && options.false_alarms_per_h > 0 && options.interval_s > 0))
    return refuse(fmt::format("a shift of {}, {} false alarms per hour and steps of {} s: each must be above 0",
                              options.shift, options.false_alarms_per_h, options.interval_s));
  constexpr double kMinRunLength = 10, kMaxRunLength = 1e9;
  const double run_length = kSecondsPerHour / (options.interval_s * options.false_alarms_per_h);
  if (!(run_length >= kMinRunLength && run_length <= kMaxRunLength))
    return refuse(
        fmt::format("{:.3g} steps between false alarms, expected {} to {}", run_length, kMinRunLength, kMaxRunLength));
  const double slack = options.shift / 2;
  return ChangeDetector(options.dimension, slack, limit_for_run_length(options.dimension, slack, run_length));
}

Change ChangeDetector::find_change() const {
  const Eigen::Index kept = std::min(known_, recent_.cols());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(sum_.size());
  Change change;
  double greatest = -1;
  for (Eigen::Index back = 1; back <= kept; ++back) {
    sum += recent_.col((known_ - back) % recent_.cols());
    const auto steps = static_cast<double>(back);
    const double square = sum.squaredNorm() / steps;
    if (square <= greatest) continue;
    greatest = square;
    change = {.steps = static_cast<int>(back), .mean = sum / steps};
  }
  return change;
}

std::optional<Change> ChangeDetector::push(const Eigen::Ref<const Eigen::VectorXd>& vector) {
  assert(vector.size() == sum_.size());
  if (!vector.allFinite()) return {};
  recent_.col(known_++ % recent_.cols()) = vector;
  if (add_less_slack(sum_, vector, slack_) - slack_ <= limit_) return {};
  const Change change = find_change();
  sum_.setZero();
  known_ = 0;
  return change;
}

}  // namespace gyrotherm::fusion
