// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/control_chart.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/assurance/run_length.hpp"
#include "analysis/data/distributions.hpp"

namespace gyrotherm::assurance {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Mean of the values since the last new level, and pooled deviation of all levels.
class Baseline {
 public:
  void start_level() { count_ = mean_ = 0; }
  void add(double value) {
    count_ += 1;
    const double before = value - mean_;
    mean_ += before / count_;
    squares_ += before * (value - mean_);
    if (count_ > 1) degrees_ += 1;
  }
  [[nodiscard]] bool can_judge() const { return count_ > 0 && degrees_ >= kFewestDegrees && squares_ > 0; }
  [[nodiscard]] double mean() const { return mean_; }
  [[nodiscard]] double degrees() const { return degrees_; }
  /// Standard deviation of the difference between a new value and the mean.
  [[nodiscard]] double deviation() const { return std::sqrt(squares_ / degrees_ * (1 + 1 / count_)); }

 private:
  double count_{}, mean_{}, squares_{}, degrees_{};
};

double to_scale(double value, ChartScale scale) {
  return scale == ChartScale::linear ? value : std::cbrt(value * value);
}

double from_scale(double value, ChartScale scale) {
  return scale == ChartScale::linear ? value : std::pow(std::max(value, 0.0), 1.5);
}

/// Returns Φ⁻¹(F_ν(t)), with the tail computed on the side of t, where it is small.
double standardise(double t, double degrees) {
  constexpr double kSmallest = 1e-14;
  const double tail = std::max(data::students_t_probability(-std::abs(t), degrees), kSmallest);
  const double q = individuals_limit(std::min(2 * tail, 1 - 1e-12));
  return std::copysign(q, t);
}

ChartPoint judge_value(const Baseline& baseline, double value, double ewma, const ChartLimits& limits,
                       ChartScale scale) {
  const double deviation = baseline.deviation();
  const double q = standardise((value - baseline.mean()) / deviation, baseline.degrees());
  const double tail = std::erfc(limits.individuals / std::sqrt(2.0));
  const double reach = data::coverage_factor(1 - tail, baseline.degrees()) * deviation;
  const double edge = limits.ewma * std::sqrt(kLambda / (2 - kLambda));
  ChartPoint point{.value = from_scale(value, scale),
                   .centre = from_scale(baseline.mean(), scale),
                   .low = from_scale(baseline.mean() - reach, scale),
                   .high = from_scale(baseline.mean() + reach, scale),
                   .q = q,
                   .ewma = (kLambda * q + (1 - kLambda) * ewma * edge) / edge,
                   .is_judged = true};
  point.individual_is_out = std::abs(q) > limits.individuals;
  point.ewma_is_out = std::abs(point.ewma) > 1;
  return point;
}

}  // namespace

ChartLimits limits_for(double rate, std::size_t charts) {
  const double each = rate / (2 * static_cast<double>(std::max<std::size_t>(charts, 1)));
  return {.individuals = individuals_limit(each), .ewma = ewma_limit(kLambda, each)};
}

std::vector<ChartPoint> judge(const std::vector<ChartInput>& runs, const ChartLimits& limits, ChartScale scale) {
  std::vector<ChartPoint> points;
  Baseline baseline;
  double ewma = 0;
  for (const ChartInput& run : runs) {
    if (run.starts_level) {
      baseline.start_level();
      ewma = 0;
    }
    ChartPoint point{
        .value = run.value, .centre = kUnknown, .low = kUnknown, .high = kUnknown, .q = kUnknown, .ewma = kUnknown};
    const double value = to_scale(run.value, scale);
    if (std::isfinite(value) && baseline.can_judge()) {
      point = judge_value(baseline, value, ewma, limits, scale);
      ewma = run.is_excluded ? 0 : point.ewma;
    }
    if (std::isfinite(value) && !run.is_excluded && !point.is_out()) baseline.add(value);
    points.push_back(point);
  }
  return points;
}

}  // namespace gyrotherm::assurance
