// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/learnt_limit.hpp"

#include <algorithm>
#include <cassert>
#include <random>

#include "analysis/fusion/change_detector.hpp"
#include "analysis/fusion/run_length.hpp"
#include "core/random.hpp"

namespace gyrotherm::fusion {
namespace {

/// Returns the mean run length over blocks of the healthy vectors, in steps; above `steps` if no alarm came.
double drawn_run_length(const Eigen::Ref<const Eigen::MatrixXd>& healthy, double slack, double limit, double steps) {
  constexpr std::uint64_t kSeed = 1;
  std::mt19937_64 random(kSeed);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(healthy.rows());
  double taken = 0;
  int alarms = 0;
  while (taken < steps) {
    const Eigen::Index from = index_below(healthy.cols(), random);
    for (Eigen::Index k = 0; k < kBlock; ++k) {
      ++taken;
      if (add_less_slack(sum, healthy.col((from + k) % healthy.cols()), slack) - slack <= limit) continue;
      ++alarms;
      sum.setZero();
    }
  }
  return alarms > 0 ? taken / alarms : 2 * steps;
}

/// Returns the place from `low` on, below `high`, up to which a rising function is less than `wanted`.
double crossing(double low, double high, double wanted, auto rising) {
  constexpr int kHalvings = 16;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (rising(middle) < wanted ? low : high) = middle;
  }
  return low;
}

}  // namespace

std::optional<double> limit_of_healthy(const Eigen::Ref<const Eigen::MatrixXd>& healthy, double slack,
                                       double run_length) {
  assert(healthy.allFinite() && slack > 0);
  if (healthy.cols() < kFewestHealthy) return std::nullopt;
  constexpr double kRuns = 400, kFarthest = 4;  // times the limit of white vectors
  const auto dimension = static_cast<int>(healthy.rows());
  const double of_white = limit_for_run_length(dimension, slack, run_length);
  const double told = std::min(run_length, static_cast<double>(healthy.cols()));
  const double least = limit_for_run_length(dimension, slack, told);
  const double drawn = crossing(least, kFarthest * least, told,
                                [&](double limit) { return drawn_run_length(healthy, slack, limit, kRuns * told); });
  if (drawn <= least) return of_white;
  if (told == run_length) return drawn;
  const double deviation = 1 / crossing(1 / kFarthest, 1, told, [&](double part) {
                             return average_run_length(dimension, slack * part, drawn * part);
                           });
  return std::max(of_white, deviation * limit_for_run_length(dimension, slack / deviation, run_length));
}

}  // namespace gyrotherm::fusion
