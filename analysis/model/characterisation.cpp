// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/characterisation.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "analysis/data/correlated_fit.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/budget.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

using RowNumbers = std::vector<Eigen::Index>;

/// Longest correlation time of a thermal model's residuals: about twice the slowest time constant (46 min) of the gyro
/// in the reference simulation.
constexpr double kMemorySeconds = 5400;
/// Shortest record with a sensitivity to the ramp rate or to a gradient: in a shorter one, noise with this memory
/// cannot be distinguished from the effect of an input.
constexpr double kShortestRegressionSeconds = 2 * kMemorySeconds;
/// Width of a temperature bin of the hysteresis loop.
constexpr double kHysteresisBinK = 10;
constexpr double kMovingKPerMin = 0.1;
/// Greatest difference between set points that are treated as equal. It covers the resolution and rounding of a
/// chamber's controller. Pooling set points over 0.5 K would add the temperature slope to the scatter.
constexpr double kSameSetPointK = 0.1 + 1e-6;
/// Least standard deviation of the temperatures from which a temperature slope is computed.
constexpr double kLeastSpreadK = 0.5;
constexpr int kFewestClusters = 3;
constexpr double kWarmUpMeanSeconds = 1000;

/// The record, and quantities from which several results are computed.
struct Subject {
  const data::Dataset& dataset;
  const data::Clusters& clusters;
  /// Means of the block's thermometers (data::block_thermometers()).
  Eigen::VectorXd temperature_c, rate_k_per_min;
  /// 1 where the unit's input axis is reversed, 0 as mounted.
  Eigen::VectorXd turned;
  Eigen::VectorXd before, after;
};

Eigen::VectorXd block_mean(const Subject& subject, const Eigen::MatrixXd& of_each) {
  const std::vector<std::string> block = data::block_thermometers(subject.dataset);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(of_each.rows());
  int count = 0;
  for (std::size_t k = 0; k < subject.clusters.thermometers.size(); ++k) {
    if (std::ranges::count(block, subject.clusters.thermometers[k]) == 0) continue;
    mean += of_each.col(static_cast<Eigen::Index>(k));
    ++count;
  }
  return mean / std::max(count, 1);
}

/// Applies `figure(values)` to the bias before and after compensation.
template <class Figure>
BeforeAfter before_and_after(const Subject& subject, Figure figure) {
  return {.before = figure(subject.before), .after = figure(subject.after)};
}

/// Combines the uncertainties of independent values.
CombinedUncertainty combine(const std::vector<MeasuredValue>& figures) {
  std::vector<BudgetRow> rows;
  for (const MeasuredValue& one : figures)
    rows.push_back({.standard_uncertainty = one.u, .degrees_of_freedom = one.degrees_of_freedom});
  return combined(rows);
}

MeasuredValue difference(const MeasuredValue& a, const MeasuredValue& b) {
  const CombinedUncertainty both = combine({a, b});
  return {a.value - b.value, both.standard_deg_per_h, both.degrees_of_freedom};
}
BeforeAfter difference(const BeforeAfter& a, const BeforeAfter& b) {
  return {.before = difference(a.before, b.before), .after = difference(a.after, b.after)};
}

/// Returns the mean of the rows. Its u accounts for the correlation of neighbouring rows. Unknown if a row is not
/// finite.
MeasuredValue mean_at(const Subject& subject, const Eigen::VectorXd& values, const RowNumbers& rows) {
  if (!values(rows).allFinite()) return {};
  const data::Figures figures = compute_figures(values(rows), subject.clusters, rows);
  return {figures.mean, standard_error_of_mean(figures), std::max(1.0, figures.effective.of_mean - 1)};
}

/// Returns the clusters that are completely inside a segment.
RowNumbers clusters_inside(const data::Clusters& clusters, int segment) {
  RowNumbers rows;
  for (Eigen::Index k = 0; k < clusters.start_s.size(); ++k) {
    if (clusters.segment(k) == segment && clusters.last_segment(k) == segment) rows.push_back(k);
  }
  return rows;
}

/// Returns the clusters of the last hour of a segment.
RowNumbers clusters_in_last_hour(const data::Clusters& clusters, int segment) {
  RowNumbers rows = clusters_inside(clusters, segment);
  if (rows.empty()) return rows;
  const double from_s = clusters.start_s(rows.back()) + clusters.length_s - data::kQuietSeconds;
  std::erase_if(rows, [&](Eigen::Index k) { return clusters.start_s(k) < from_s - 0.5 * clusters.length_s; });
  return rows;
}

double segment_seconds(const data::Clusters& clusters, int segment) {
  return clusters.length_s * static_cast<double>((clusters.segment.array() == segment).count());
}

std::vector<StabilisedBias> stabilised_biases(const Subject& subject) {
  std::vector<StabilisedBias> all;
  for (std::size_t s = 0; s < subject.dataset.segments.size(); ++s) {
    const auto segment = static_cast<int>(s);
    const auto& [name, hold, target, rate, cycle, prompt, unit] = subject.dataset.segments[s];
    if (!hold || unit.off || segment_seconds(subject.clusters, segment) < kStabilisedHoldSeconds) continue;
    const RowNumbers rows = clusters_in_last_hour(subject.clusters, segment);
    if (static_cast<int>(rows.size()) < kFewestClusters) continue;
    all.push_back({.segment = segment,
                   .turned = unit.turned,
                   .set_point_c = target.value,
                   .temperature_c = subject.temperature_c(rows).mean(),
                   .clusters = static_cast<int>(rows.size()),
                   .bias = before_and_after(subject, [&](const auto& bias) { return mean_at(subject, bias, rows); })});
  }
  return all;
}

/// Returns the common slope of straight lines through the points. Each position of the unit has its own line, because
/// the positions differ by the residual Earth rate. u is computed from the scatter about the lines. Unknown if there
/// are too few points or if their range of temperature is too small.
MeasuredValue temperature_slope(const std::vector<StabilisedBias>& points, MeasuredValue BeforeAfter::*which) {
  const auto count = std::ssize(points);
  Eigen::VectorXd t(count), b(count);
  // Points in the mounted and in the turned position.
  std::array<RowNumbers, 2> positions;
  for (Eigen::Index k = 0; k < count; ++k) {
    const StabilisedBias& point = points[static_cast<std::size_t>(k)];
    t(k) = point.temperature_c;
    b(k) = (point.bias.*which).value;
    positions[point.turned ? 1 : 0].push_back(k);
  }
  auto freedom = static_cast<double>(count - 1);
  for (const RowNumbers& rows : positions) {
    if (rows.empty()) continue;
    t(rows).array() -= t(rows).mean();
    b(rows).array() -= b(rows).mean();
    --freedom;
  }
  if (freedom < 1 || !b.allFinite()) return {};
  const double spread = t.squaredNorm();
  if (spread < kLeastSpreadK * kLeastSpreadK * static_cast<double>(count)) return {};
  const double slope = t.dot(b) / spread;
  return {slope, std::sqrt((b - slope * t).squaredNorm() / freedom / spread), freedom};
}

int correlation_reach(const Subject& subject) { return static_cast<int>(kMemorySeconds / subject.clusters.length_s); }

/// Returns true if the clusters cover less than kShortestRegressionSeconds.
bool is_too_short(const Subject& subject) {
  return static_cast<double>(subject.clusters.start_s.size()) * subject.clusters.length_s < kShortestRegressionSeconds;
}

/// Returns the coefficient of `input` in a regression with the temperature and a constant per position of the unit,
/// because the positions differ by the residual Earth rate. Unknown if the record is too short or the input does not
/// vary independently.
MeasuredValue regression_coefficient(const Subject& subject, const Eigen::VectorXd& input,
                                     const Eigen::VectorXd& bias) {
  Eigen::MatrixXd all(bias.size(), 5);
  all << Eigen::VectorXd::Ones(bias.size()), subject.temperature_c, input, subject.turned, bias;
  const RowNumbers rows = data::finite_rows(all);
  constexpr Eigen::Index kInput = 2, kTurned = 3, kBias = 4;
  const auto has_both_positions = [&] { return all(rows, kTurned).minCoeff() < all(rows, kTurned).maxCoeff(); };
  const Eigen::Index columns = !rows.empty() && has_both_positions() ? kBias : kTurned;
  if (static_cast<Eigen::Index>(rows.size()) <= 2 * columns || is_too_short(subject)) return {};
  const Eigen::MatrixXd x = all(rows, Eigen::seqN(0, columns));
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x);
  constexpr double kRelative = 1e-9;
  qr.setThreshold(kRelative);
  if (qr.rank() < columns) return {};
  const data::CorrelatedFit fit = data::fit_with_correlated_noise(
      x, all(rows, kBias), cluster_positions(subject.clusters, rows), correlation_reach(subject));
  return {fit.coefficients(kInput), fit.u(kInput)};
}

/// Returns the raw bias minus its mean in each position, because the positions differ by the residual Earth rate.
Eigen::VectorXd subtract_position_means(const Subject& subject) {
  Eigen::VectorXd bias = subject.clusters.bias_deg_per_h;
  for (const double position : {0.0, 1.0}) {
    RowNumbers rows;
    for (const Eigen::Index k : data::finite_rows(bias))
      if (subject.turned(k) == position) rows.push_back(k);
    if (!rows.empty()) bias(rows).array() -= bias(rows).mean();
  }
  return bias;
}

/// Returns the pair of thermometers whose difference has the greatest correlation with the raw bias.
std::pair<std::string, Eigen::VectorXd> greatest_gradient(const Subject& subject) {
  data::Clusters clusters = subject.clusters;
  clusters.bias_deg_per_h = subtract_position_means(subject);
  const data::Correlation correlation = correlate(clusters, subject.dataset.gradients);
  Eigen::Index i = 0, j = 0;
  if (correlation.gradient.size() == 0 || !(correlation.gradient.cwiseAbs().maxCoeff(&i, &j) > 0)) return {};
  if (i > j) std::swap(i, j);
  const auto column = [&](Eigen::Index k) {
    const auto at = std::ranges::find(clusters.thermometers, correlation.names[static_cast<std::size_t>(k)]);
    return clusters.temperature_c.col(at - clusters.thermometers.begin());
  };
  return {correlation.names[static_cast<std::size_t>(i)] + "-" + correlation.names[static_cast<std::size_t>(j)],
          column(i) - column(j)};
}

/// Returns the mean bias during heating minus the mean bias during cooling. A straight line in temperature corrects for
/// different mean temperatures, which occur if one of the two passes leaves the span early.
MeasuredValue loop_width(const Subject& subject, const Eigen::VectorXd& bias, const RowNumbers& heating,
                         const RowNumbers& cooling) {
  RowNumbers both;
  std::ranges::merge(heating, cooling, std::back_inserter(both));
  if (!bias(both).allFinite()) return {};
  const auto temperature = [&](const RowNumbers& rows) { return subject.temperature_c(rows).array(); };
  Eigen::MatrixXd x(std::ssize(both), 3);
  x.col(0).setOnes();
  x.col(1) = subject.rate_k_per_min(both).unaryExpr([](double rate) { return rate > 0 ? 0.5 : -0.5; });
  x.col(2) = temperature(both) - temperature(both).mean();
  const RobustFit fit =
      fit_robustly(x, bias(both), cluster_positions(subject.clusters, both), correlation_reach(subject));
  const Eigen::VectorXd level = bias - fit.coefficients(2) * subject.temperature_c;
  const MeasuredValue above = mean_at(subject, level, heating), below = mean_at(subject, level, cooling);
  const double apart_k = std::abs(temperature(heating).mean() - temperature(cooling).mean());
  const CombinedUncertainty all =
      combine({above, below, {0, apart_k * fit.u(2), above.degrees_of_freedom + below.degrees_of_freedom}});
  return {above.value - below.value, all.standard_deg_per_h, all.degrees_of_freedom};
}

std::vector<HysteresisPoint> hysteresis_loop(const Subject& subject) {
  // Heating and cooling rows, by position.
  std::map<std::pair<int, bool>, std::pair<RowNumbers, RowNumbers>> spans;
  for (Eigen::Index k = 0; k < subject.temperature_c.size(); ++k) {
    const double rate = subject.rate_k_per_min(k);
    if (!(std::abs(rate) > kMovingKPerMin) || !std::isfinite(subject.temperature_c(k))) continue;
    auto& span =
        spans[{static_cast<int>(std::lround(subject.temperature_c(k) / kHysteresisBinK)), subject.turned(k) > 0}];
    (rate > 0 ? span.first : span.second).push_back(k);
  }
  std::vector<HysteresisPoint> loop;
  for (const auto& [at, span] : spans) {
    const RowNumbers &heating = span.first, &cooling = span.second;
    if (std::min(heating.size(), cooling.size()) < static_cast<std::size_t>(kFewestClusters)) continue;
    loop.push_back({.temperature_c = at.first * kHysteresisBinK,
                    .heating = static_cast<int>(heating.size()),
                    .cooling = static_cast<int>(cooling.size()),
                    .width = before_and_after(
                        subject, [&](const auto& bias) { return loop_width(subject, bias, heating, cooling); })});
  }
  return loop;
}

std::vector<Retrace> find_retrace(const std::vector<StabilisedBias>& stabilised) {
  std::vector<Retrace> all;
  for (std::size_t k = 1; k < stabilised.size(); ++k) {
    // Positions differ by the residual Earth rate.
    if (stabilised[k].turned != stabilised[0].turned) continue;
    if (std::abs(stabilised[k].set_point_c - stabilised[0].set_point_c) > kSameSetPointK) continue;
    all.push_back({.segment = stabilised[k].segment,
                   .set_point_c = stabilised[k].set_point_c,
                   .change = difference(stabilised[k].bias, stabilised[0].bias)});
  }
  return all;
}

/// Finds the settling time from the start of the first hold: the end of the last mean over kWarmUpMeanSeconds that
/// differs from the final bias by more than 3 standard deviations.
void find_settling(WarmUp& warm_up, const Subject& subject, const RowNumbers& hold, const StabilisedBias& settled_in,
                   double floor_deg_per_h, MeasuredValue BeforeAfter::*which, const Eigen::VectorXd& bias) {
  const double length_s = subject.clusters.length_s;
  const auto count = static_cast<std::size_t>(std::max(1.0, std::round(kWarmUpMeanSeconds / length_s)));
  const MeasuredValue& settled = settled_in.bias.*which;
  const double within = 3 * std::hypot(floor_deg_per_h / std::sqrt(static_cast<double>(count)), settled.u);
  (warm_up.within.*which).value = within;
  const double start_s = subject.clusters.start_s(hold.front());
  const double last_hour_s = subject.clusters.start_s(hold.back()) + length_s - data::kQuietSeconds;
  double seconds = 0;
  for (std::size_t k = 0; k + count <= hold.size(); ++k) {
    const RowNumbers rows(hold.begin() + static_cast<std::ptrdiff_t>(k),
                          hold.begin() + static_cast<std::ptrdiff_t>(k + count));
    const double end_s = subject.clusters.start_s(rows.back()) + length_s;
    if (std::abs(bias(rows).mean() - settled.value) <= within) continue;  // not for a NaN
    if (end_s > last_hour_s) return;
    seconds = end_s - start_s;
  }
  (warm_up.seconds.*which).value = seconds;
}

WarmUp evaluate_warm_up(const Subject& subject, const StabilisedBias& start, double floor_deg_per_h) {
  const RowNumbers hold = clusters_inside(subject.clusters, start.segment);
  WarmUp warm_up{.segment = start.segment, .set_point_c = start.set_point_c, .within = {}, .seconds = {}};
  find_settling(warm_up, subject, hold, start, floor_deg_per_h, &BeforeAfter::before, subject.before);
  find_settling(warm_up, subject, hold, start, floor_deg_per_h, &BeforeAfter::after, subject.after);
  return warm_up;
}

/// Returns the time of a segment's first bias since the start of the run; NaN if there is none.
double first_bias_s(const data::Dataset& dataset, int segment) {
  for (Eigen::Index i = 0; i < dataset.segment.size(); ++i)
    if (dataset.segment(i) == segment && std::isfinite(dataset.bias_deg_per_h(i))) return dataset.time_s(i);
  return std::numeric_limits<double>::quiet_NaN();
}

/// Returns true if the unit was switched on in this hold: the record begins with the hold, or the unit was off before
/// it. The clusters may be a selected part of the record. They must contain the hold from its first bias on, except for
/// less than one warm-up mean.
bool is_switch_on_hold(const Subject& subject, const StabilisedBias& hold) {
  const data::Dataset& dataset = subject.dataset;
  const bool begins = dataset.segment.size() > 0 && dataset.segment(0) == hold.segment;
  const bool was_off = hold.segment > 0 && dataset.segments[static_cast<std::size_t>(hold.segment) - 1].unit.off;
  if (!begins && !was_off) return false;
  const double from_s = subject.clusters.start_s(clusters_inside(subject.clusters, hold.segment).front());
  return from_s - first_bias_s(dataset, hold.segment) < kWarmUpMeanSeconds;
}

std::vector<WarmUp> find_warm_ups(const Subject& subject, const std::vector<StabilisedBias>& stabilised) {
  const data::NoiseFloor floor = noise_floor(subject.clusters, subject.dataset);
  if (!std::isfinite(floor.deg_per_h)) return {};
  std::vector<WarmUp> all;
  for (const StabilisedBias& hold : stabilised)
    if (is_switch_on_hold(subject, hold)) all.push_back(evaluate_warm_up(subject, hold, floor.deg_per_h));
  return all;
}

/// Returns the mean of several values. Its u is the greater of two estimates: from the combined uncertainties of the
/// values and from their scatter.
MeasuredValue mean_with_scatter(const std::vector<MeasuredValue>& figures) {
  const auto count = std::ssize(figures);
  Eigen::VectorXd values(count);
  for (Eigen::Index k = 0; k < count; ++k) values(k) = figures[static_cast<std::size_t>(k)].value;
  const CombinedUncertainty own = combine(figures);
  MeasuredValue mean{values.mean(), own.standard_deg_per_h / static_cast<double>(count), own.degrees_of_freedom};
  const double scatter = count > 1 ? data::compute_figures(values).std / std::sqrt(static_cast<double>(count)) : 0;
  if (scatter > mean.u) mean = {mean.value, scatter, static_cast<double>(count - 1)};
  return mean;
}

/// Groups holds by set point, in ascending order; each group keeps its order.
std::vector<std::vector<const StabilisedBias*>> group_by_set_point(std::vector<const StabilisedBias*> holds) {
  std::ranges::stable_sort(holds, {}, &StabilisedBias::set_point_c);
  std::vector<std::vector<const StabilisedBias*>> groups;
  for (const StabilisedBias* hold : holds) {
    if (groups.empty() || hold->set_point_c - groups.back().front()->set_point_c > kSameSetPointK)
      groups.emplace_back();
    groups.back().push_back(hold);
  }
  return groups;
}

std::vector<TwoPosition> find_two_positions(const Subject& subject, const std::vector<StabilisedBias>& stabilised) {
  std::vector<const StabilisedBias*> every;
  for (const StabilisedBias& hold : stabilised) every.push_back(&hold);
  const std::optional<double>& stated = subject.dataset.earth_rate_deg_per_h;
  std::vector<TwoPosition> all;
  for (const auto& group : group_by_set_point(std::move(every))) {
    // Holds in the mounted and in the turned position.
    std::array<std::vector<const StabilisedBias*>, 2> holds;
    for (const StabilisedBias* hold : group) holds[hold->turned ? 1 : 0].push_back(hold);
    if (holds[0].empty() || holds[1].empty()) continue;
    TwoPosition found{.set_point_c = holds[0].front()->set_point_c,
                      .as_mounted = static_cast<int>(holds[0].size()),
                      .turned = static_cast<int>(holds[1].size()),
                      .bias = {},
                      .earth_rate = {}};
    if (stated) found.stated_earth_rate_deg_per_h = *stated;
    for (const auto which : {&BeforeAfter::before, &BeforeAfter::after}) {
      std::array<MeasuredValue, 2> sides;
      for (std::size_t side = 0; side < 2; ++side) {
        std::vector<MeasuredValue> figures;
        for (const StabilisedBias* hold : holds[side]) figures.push_back(hold->bias.*which);
        sides[side] = mean_with_scatter(figures);
      }
      const CombinedUncertainty both = combine({sides.begin(), sides.end()});
      const double u = both.standard_deg_per_h / 2, freedom = both.degrees_of_freedom;
      found.bias.*which = {(sides[0].value + sides[1].value) / 2, u, freedom};
      found.earth_rate.*which = {(sides[0].value - sides[1].value) / 2 + stated.value_or(0), u, freedom};
    }
    all.push_back(found);
  }
  return all;
}

std::string make_statement(const Characterisation& result) {
  if (result.stabilised.empty()) return "no hold lasts 1.5 h or more, so there is no hold bias";
  return fmt::format("last hour of {} hold{} of 1.5 h or more", result.stabilised.size(),
                     result.stabilised.size() == 1 ? "" : "s");
}

}  // namespace

RobustFit fit_robustly(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const Eigen::VectorXi& positions,
                       int reach) {
  assert(x.rows() > x.cols() && y.size() == x.rows() && positions.size() == x.rows() && reach >= 0);
  RobustFit fit{.coefficients = x.colPivHouseholderQr().solve(y), .u = {}};
  const Eigen::VectorXd residual = y - x * fit.coefficients;
  const Eigen::MatrixXd scores = residual.asDiagonal() * x;
  Eigen::MatrixXd sum = scores.transpose() * scores;
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    for (Eigen::Index l = k + 1; l < x.rows() && positions(l) - positions(k) <= reach; ++l) {
      const double weight = 1 - static_cast<double>(positions(l) - positions(k)) / (reach + 1);
      const Eigen::MatrixXd product = weight * scores.row(k).transpose() * scores.row(l);
      sum += product + product.transpose();
    }
  }
  const Eigen::MatrixXd inverse = (x.transpose() * x).inverse();
  const double small_sample = static_cast<double>(x.rows()) / static_cast<double>(x.rows() - x.cols());
  fit.u = (small_sample * (inverse * sum * inverse).diagonal()).cwiseMax(0).cwiseSqrt();
  return fit;
}

const HysteresisPoint* find_widest(const std::vector<HysteresisPoint>& loop, MeasuredValue BeforeAfter::*which) {
  const HysteresisPoint* found = nullptr;
  for (const HysteresisPoint& point : loop) {
    const double width = std::abs((point.width.*which).value);
    if (std::isfinite(width) && (found == nullptr || width > std::abs((found->width.*which).value))) found = &point;
  }
  return found;
}

Characterisation characterise(const data::Dataset& dataset, const data::Clusters& clusters,
                              const Eigen::VectorXd& residual_deg_per_h) {
  assert(residual_deg_per_h.size() == clusters.bias_deg_per_h.size());
  assert(clusters.last_segment.size() == clusters.segment.size());
  Subject subject{.dataset = dataset,
                  .clusters = clusters,
                  .temperature_c = {},
                  .rate_k_per_min = {},
                  .turned = {},
                  .before = clusters.bias_deg_per_h,
                  .after = residual_deg_per_h};
  subject.temperature_c = block_mean(subject, clusters.temperature_c);
  subject.rate_k_per_min = block_mean(subject, clusters.rate_c_per_min);
  subject.turned = clusters.segment.cast<double>().unaryExpr([&](double segment) {
    return segment >= 0 && dataset.segments[static_cast<std::size_t>(segment)].unit.turned ? 1.0 : 0.0;
  });
  const auto regress_with_temperature = [&](const Eigen::VectorXd& input) {
    return before_and_after(subject, [&](const auto& bias) { return regression_coefficient(subject, input, bias); });
  };
  Characterisation result;
  result.zero = dataset.bias_zero + (dataset.has_own_reference ? " of " + dataset.run_id : "");
  result.stabilised = stabilised_biases(subject);
  result.temperature = {.before = temperature_slope(result.stabilised, &BeforeAfter::before),
                        .after = temperature_slope(result.stabilised, &BeforeAfter::after)};
  result.ramp = regress_with_temperature(subject.rate_k_per_min);
  if (is_too_short(subject))
    result.sensitivity_statement =
        fmt::format("the clusters cover less than {:g} h, so there is no sensitivity to the ramp rate or to a gradient",
                    kShortestRegressionSeconds / kSecondsPerHour);
  if (auto [name, gradient] = greatest_gradient(subject); !name.empty()) {
    result.gradient = std::move(name);
    result.of_gradient = regress_with_temperature(gradient);
  }
  result.hysteresis = hysteresis_loop(subject);
  result.retrace = find_retrace(result.stabilised);
  result.two_position = find_two_positions(subject, result.stabilised);
  result.warm_ups = find_warm_ups(subject, result.stabilised);
  result.statement = make_statement(result);
  return result;
}

std::string describe_switch_on(const WarmUp& warm_up) {
  return warm_up.segment == 0 ? "with the run" : fmt::format("in segment {}", warm_up.segment + 1);
}

std::vector<TurnOn> turn_on_scatter(const std::vector<Characterisation>& records) {
  constexpr std::size_t kFewestStarts = 3;
  // Holds by bias reference and position.
  std::map<std::pair<std::string, bool>, std::vector<const StabilisedBias*>> comparable;
  for (const Characterisation& record : records)
    for (const WarmUp& start : record.warm_ups) {
      const auto hold = std::ranges::find(record.stabilised, start.segment, &StabilisedBias::segment);
      if (hold != record.stabilised.end()) comparable[{record.zero, hold->turned}].push_back(&*hold);
    }
  const auto scatter = [](const std::vector<const StabilisedBias*>& starts, MeasuredValue BeforeAfter::*which) {
    Eigen::VectorXd values(std::ssize(starts));
    for (std::size_t k = 0; k < starts.size(); ++k)
      values(static_cast<Eigen::Index>(k)) = (starts[k]->bias.*which).value;
    return data::compute_figures(values).std;
  };
  std::vector<TurnOn> all;
  for (auto& [of, holds] : comparable)
    for (const auto& starts : group_by_set_point(std::move(holds)))
      if (starts.size() >= kFewestStarts)
        all.push_back({.set_point_c = starts.front()->set_point_c,
                       .starts = static_cast<int>(starts.size()),
                       .std_before_deg_per_h = scatter(starts, &BeforeAfter::before),
                       .std_after_deg_per_h = scatter(starts, &BeforeAfter::after)});
  std::ranges::stable_sort(all, {}, &TurnOn::set_point_c);
  return all;
}

}  // namespace gyrotherm::model
