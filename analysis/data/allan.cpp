#include "analysis/data/allan.hpp"

#include <cassert>
#include <cmath>

namespace gyrotherm {
namespace {

/// θ of NIST SP 1065: the running sum, one longer than the values.
Eigen::VectorXd running_sum(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Eigen::VectorXd sum(values.size() + 1);
  sum(0) = 0;
  for (Eigen::Index i = 0; i < values.size(); ++i) sum(i + 1) = sum(i) + values(i);
  return sum;
}

struct SquareSum {
  double sum{};
  int count{};
};

SquareSum squared_differences(const Eigen::VectorXd& theta, Eigen::Index m) {
  const Eigen::Index count = theta.size() - 2 * m;
  if (count < 1) return {};
  const auto second_difference = theta.tail(count) - 2 * theta.segment(m, count) + theta.head(count);
  return {second_difference.squaredNorm(), static_cast<int>(count)};
}

double deviation_of(const SquareSum& squares, double m) { return std::sqrt(squares.sum / squares.count / 2) / m; }

/// Σ(K − 1), K means of m samples in each stretch.
int independent_differences(const RateStretches& rates, Eigen::Index m) {
  int count = 0;
  for (const Eigen::VectorXd& stretch : rates.values) {
    if (stretch.size() >= 2 * m) count += static_cast<int>(stretch.size() / m - 1);
  }
  return count;
}

}  // namespace

RateStretches cut_at_gaps(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                          const Eigen::Ref<const Eigen::VectorXd>& rate_deg_per_h, double interval_s) {
  assert(time_s.size() == rate_deg_per_h.size() && interval_s > 0);
  RateStretches rates{.interval_s = interval_s, .values = {}};
  Eigen::Index first = 0;
  for (Eigen::Index k = 0; k <= time_s.size(); ++k) {
    const bool known = k < time_s.size() && std::isfinite(rate_deg_per_h(k));
    const bool goes_on = known && (k == first || std::abs(time_s(k) - time_s(k - 1) - interval_s) < 0.5 * interval_s);
    if (goes_on) continue;
    if (k > first) rates.values.emplace_back(rate_deg_per_h.segment(first, k - first));
    first = known ? k : k + 1;
  }
  return rates;
}

double overlapping_allan_deviation(const Eigen::Ref<const Eigen::VectorXd>& values, int m) {
  assert(m >= 1 && values.size() >= 2 * m);
  return deviation_of(squared_differences(running_sum(values), m), m);
}

AllanCurve allan_curve(const RateStretches& rates) {
  std::vector<Eigen::VectorXd> thetas;
  for (const Eigen::VectorXd& stretch : rates.values) thetas.push_back(running_sum(stretch));
  AllanCurve curve;
  constexpr int kLeastDifferences = 2;
  for (int m = 1;; m *= 2) {
    const int independent = independent_differences(rates, m);
    if (independent < kLeastDifferences) return curve;
    SquareSum all;
    for (const Eigen::VectorXd& theta : thetas) {
      const SquareSum of = squared_differences(theta, m);
      all = {all.sum + of.sum, all.count + of.count};
    }
    const double deviation = deviation_of(all, m);
    curve.push_back({.m = m,
                     .tau_s = m * rates.interval_s,
                     .deviation_deg_per_h = deviation,
                     .error_deg_per_h = deviation / std::sqrt(2.0 * independent),
                     .differences = all.count});
  }
}

}  // namespace gyrotherm
