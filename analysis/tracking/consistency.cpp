// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/consistency.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "analysis/data/distributions.hpp"

namespace gyrotherm::tracking {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The values by a power of 2, such that the greatest has a square: a correlation is the same of both, to the bit.
Eigen::VectorXd of_moderate_size(const Eigen::Ref<const Eigen::VectorXd>& values) {
  double greatest = 0;
  for (const double value : values)
    if (std::isfinite(value)) greatest = std::max(greatest, std::abs(value));
  if (greatest == 0) return values;
  const int exponent = std::ilogb(greatest);
  return values.unaryExpr([exponent](double value) { return std::scalbn(value, -exponent); });
}

}  // namespace

Whiteness whiteness_of(const Eigen::Ref<const Eigen::VectorXd>& values, int lags) {
  assert(lags >= 1);
  Whiteness whiteness{.lags = lags, .probability = kUnknown};
  const Eigen::VectorXd scaled = of_moderate_size(values);
  double squares = 0;
  int count = 0;
  for (const double value : scaled) {
    if (!std::isfinite(value)) continue;
    squares += value * value;
    ++count;
  }
  if (count <= 2 * lags || squares == 0) return whiteness;
  const double variance = squares / count;
  for (Eigen::Index lag = 1; lag <= lags; ++lag) {
    double products = 0;
    int pairs = 0;
    for (Eigen::Index k = lag; k < scaled.size(); ++k) {
      if (!std::isfinite(scaled(k)) || !std::isfinite(scaled(k - lag))) continue;
      products += scaled(k) * scaled(k - lag);
      ++pairs;
    }
    if (pairs == 0) continue;
    const double correlation = products / (variance * count);
    whiteness.statistic += correlation * correlation / pairs;
  }
  whiteness.statistic *= static_cast<double>(count) * (count + 2);
  whiteness.probability = data::chi_squared_exceeds(whiteness.statistic, lags);
  return whiteness;
}

Consistency consistency_of(const std::vector<TrackedInterval>& intervals, std::size_t settling) {
  constexpr int kLags = 20;
  Consistency consistency{.mean_square = kUnknown, .low = kUnknown, .high = kUnknown};
  const std::size_t count = intervals.size() > settling ? intervals.size() - settling : 0;
  Eigen::VectorXd normalised(static_cast<Eigen::Index>(count));
  double sum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const TrackedInterval& interval = intervals[settling + k];
    const double value = interval.innovation / std::sqrt(interval.innovation_variance);
    normalised(static_cast<Eigen::Index>(k)) = value;
    if (!std::isfinite(value)) continue;
    sum += value * value;
    ++consistency.innovations;
  }
  consistency.whiteness = whiteness_of(normalised, kLags);
  if (consistency.innovations == 0) return consistency;
  constexpr double kTwoSided95 = 1.959963985;
  const double bar = kTwoSided95 * std::sqrt(2.0 / consistency.innovations);
  consistency.mean_square = sum / consistency.innovations;
  consistency.low = 1 - bar;
  consistency.high = 1 + bar;
  return consistency;
}

}  // namespace gyrotherm::tracking
