// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/change_detector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "analysis/fusion/run_length.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::fusion {

ChangeDetector::ChangeDetector(int dimension, double slack, double limit)
    : slack_(slack), limit_(limit), sum_(Eigen::VectorXd::Zero(dimension)) {
  constexpr double kReach = 8, kLongest = 1e6;
  recent_ = Eigen::MatrixXd::Zero(dimension, static_cast<Eigen::Index>(1 + std::min(kReach * limit / slack, kLongest)));
}

Result<ChangeDetector> ChangeDetector::make(const ChangeOptions& options) {
  const auto wrong = [](std::string what) {
    return failure(FaultKind::usage, "detection of changes", std::move(what));
  };
  if (options.dimension < 1) return wrong(fmt::format("vectors of {} numbers", options.dimension));
  if (!(options.shift > 0 && options.false_alarms_per_h > 0 && options.interval_s > 0))
    return wrong(fmt::format("a shift of {}, {} false alarms per hour and steps of {} s: each must be above 0",
                             options.shift, options.false_alarms_per_h, options.interval_s));
  constexpr double kFewest = 10, kMost = 1e9;
  const double run_length = kSecondsPerHour / (options.interval_s * options.false_alarms_per_h);
  if (!(run_length >= kFewest && run_length <= kMost))
    return wrong(fmt::format("{:.3g} steps between false alarms; at least {} and at most {} can be had", run_length,
                             kFewest, kMost));
  const double slack = options.shift / 2;
  return ChangeDetector(options.dimension, slack, limit_for_run_length(options.dimension, slack, run_length));
}

Change ChangeDetector::since_likeliest_start() const {
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
  const Change change = since_likeliest_start();
  sum_.setZero();
  known_ = 0;
  return change;
}

}  // namespace gyrotherm::fusion
