// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/hold_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "core/count_text.hpp"

namespace gyrotherm::data {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Cluster length at which results are reported.
constexpr double kClusterSeconds = 100;

/// Rows first … first + count − 1 of samples or clusters.
struct Rows {
  Eigen::Index first{}, count{};
};

/// Finds the runs of rows in one hold. `hold_at` returns the segment of a row, or −1. A segment that is left and
/// entered again gives two runs.
template <class HoldAt>
std::vector<Rows> find_holds(Eigen::Index rows, const std::vector<record::RunInfo::SegmentInfo>& segments,
                             HoldAt hold_at) {
  std::vector<Rows> holds;
  int open = -1;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const int segment = hold_at(k);
    const bool inside = segment >= 0 && segments[static_cast<std::size_t>(segment)].hold;
    if (inside && segment != open) holds.push_back({k, 0});
    if (inside) ++holds.back().count;
    open = inside ? segment : -1;
  }
  return holds;
}

bool are_neighbours(const Clusters& clusters, Eigen::Index k) {
  const double step_s = clusters.start_s(k + 1) - clusters.start_s(k);
  return std::abs(step_s - clusters.length_s) < 0.5 * clusters.length_s;
}

/// Number of second differences, and number of overlapping pairs.
struct Overlaps {
  /// Pairs that share two clusters, and pairs that share one.
  int differences{}, by_two{}, by_one{};
};

/// Returns the relative standard error of the root mean square of second differences of white noise. Differences that
/// share two clusters have the correlation −2/3; those that share one have 1/6. The correlation of the squares of two
/// normal variables is the square of their correlation. The mean of D squares thus has the relative variance (2 +
/// 4·(4/9·P₂ + 1/36·P₁)/D)/D, and its root has half the relative error.
double relative_error(const Overlaps& overlaps) {
  const double d = overlaps.differences;
  return 0.5 * std::sqrt((2 + 4 * (overlaps.by_two * 4.0 / 9 + overlaps.by_one / 36.0) / d) / d);
}

bool any_hold(const std::vector<record::RunInfo::SegmentInfo>& segments) {
  return std::ranges::any_of(segments, &record::RunInfo::SegmentInfo::hold);
}

constexpr const char* kNoHold = "the record has no hold";

/// Sum of squared second differences, and their overlaps.
struct SecondDifferences {
  double sum{};
  Overlaps overlaps;
};

/// Adds the second differences in the last hour of a hold.
void add_second_differences(SecondDifferences& all, const Clusters& clusters, const Rows& hold) {
  const Eigen::Index last = hold.first + hold.count - 1;
  const double from_s = clusters.start_s(last) + clusters.length_s - kQuietSeconds;
  const auto is_used = [&](Eigen::Index k) {
    return k >= hold.first && k + 2 <= last && clusters.start_s(k) >= from_s - 0.5 * clusters.length_s &&
           are_neighbours(clusters, k) && are_neighbours(clusters, k + 1);
  };
  for (Eigen::Index k = hold.first; k + 2 <= last; ++k) {
    if (!is_used(k)) continue;
    const auto b = clusters.bias_deg_per_h.segment(k, 3);
    const double difference = b(2) - 2 * b(1) + b(0);
    all.sum += difference * difference;
    ++all.overlaps.differences;
    all.overlaps.by_two += is_used(k + 1) ? 1 : 0;
    all.overlaps.by_one += is_used(k + 2) ? 1 : 0;
  }
}

/// Computes the noise floor without its statement; see NoiseFloor for the correction of the quantisation.
NoiseFloor floor_from(const SecondDifferences& all, double step_deg_per_h, double length_s) {
  constexpr double kQuantisationShare = 0.6;
  const double observed = all.sum / (6.0 * all.overlaps.differences), per_pulse = step_deg_per_h / length_s;
  const double floor = std::sqrt(std::max(observed - per_pulse * per_pulse / 9, kQuantisationShare * observed));
  return {.deg_per_h = floor,
          .differences = all.overlaps.differences,
          .error_deg_per_h = floor * relative_error(all.overlaps)};
}

/// Returns four robust standard deviations of the finite values; infinite if more than half of them are 0.
double robust_limit(const Eigen::VectorXd& values) {
  constexpr double kPerMedian = 1.4826, kLimit = 4, kNone = std::numeric_limits<double>::infinity();
  std::vector<double> magnitudes;
  for (const double value : values)
    if (std::isfinite(value)) magnitudes.push_back(std::abs(value));
  if (magnitudes.empty()) return kNone;
  const auto middle = magnitudes.begin() + std::ssize(magnitudes) / 2;
  std::ranges::nth_element(magnitudes, middle);
  return *middle > 0 ? kLimit * kPerMedian * *middle : kNone;
}

Rows last_hour(const Dataset& dataset, const Rows& hold, double interval_s) {
  const Eigen::Index end = hold.first + hold.count;
  const double from_s = dataset.time_s(end - 1) + interval_s - kQuietSeconds;
  Eigen::Index first = hold.first;
  while (dataset.time_s(first) < from_s - 0.5 * interval_s) ++first;
  return {first, end - first};
}

/// Interpolates the prediction at each sample linearly between the middles of neighbouring clusters. NaN elsewhere.
Eigen::VectorXd interpolate_at_samples(const Dataset& dataset, const Clusters& clusters,
                                       const Eigen::VectorXd& predicted) {
  Eigen::VectorXd at = Eigen::VectorXd::Constant(dataset.time_s.size(), std::numeric_limits<double>::quiet_NaN());
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const double in_clusters = dataset.time_s(i) - 0.5 * clusters.length_s;
    while (k + 1 < clusters.start_s.size() && clusters.start_s(k + 1) <= in_clusters) ++k;
    if (k + 1 >= clusters.start_s.size() || in_clusters < clusters.start_s(k)) continue;
    const double step_s = clusters.start_s(k + 1) - clusters.start_s(k);
    if (std::abs(step_s - clusters.length_s) > 0.5 * clusters.length_s) continue;
    const double part = (in_clusters - clusters.start_s(k)) / step_s;
    at(i) = (1 - part) * predicted(k) + part * predicted(k + 1);
  }
  return at;
}

std::string summarise(const HoldNoise& noise, const char* bias, const char* caution) {
  if (noise.curve.empty()) return "no hold has enough samples without a gap";
  return fmt::format(
      "{} bias, one sample per {:g} s, in the last hour of {}: {} stretch{} without a gap, {:.0f} "
      "s in total{}",
      bias, noise.interval_s, format_count(noise.holds, "hold"), noise.stretches, noise.stretches == 1 ? "" : "es",
      noise.seconds, caution);
}

/// Inserts the point at `tau_s` into a curve of doubling τ. Does nothing if `tau_s` is not a whole number of samples or
/// is past the end of the curve.
void add_point(AllanCurve& curve, const RateStretches& rates, double tau_s) {
  constexpr double kRoundingTolerance = 1e-6;
  const double samples = tau_s / rates.interval_s;
  const int m = static_cast<int>(std::lround(samples));
  if (m < 1 || std::abs(samples - m) > kRoundingTolerance * samples || m > curve.back().m) return;
  const auto position = std::ranges::lower_bound(curve, m, {}, &AllanPoint::m);
  if (position->m != m) curve.insert(position, allan_point(rates, m));
}

HoldNoise measure_noise(const Dataset& dataset, const Eigen::VectorXd& bias_deg_per_h) {
  HoldNoise noise{.curve = {}, .fit = {}, .statement = {}};
  noise.interval_s = sample_interval_s(dataset);
  RateStretches rates{.interval_s = noise.interval_s, .values = {}};
  const Eigen::Index rows = noise.interval_s > 0 ? dataset.time_s.size() : 0;
  for (const Rows& hold : find_holds(rows, dataset.segments, [&](Eigen::Index k) { return dataset.segment(k); })) {
    const Rows hour = last_hour(dataset, hold, noise.interval_s);
    RateStretches hold_rates = cut_at_gaps(dataset.time_s.segment(hour.first, hour.count),
                                           bias_deg_per_h.segment(hour.first, hour.count), noise.interval_s);
    noise.holds += hold_rates.values.empty() ? 0 : 1;
    std::ranges::move(hold_rates.values, std::back_inserter(rates.values));
  }
  noise.stretches = static_cast<int>(rates.values.size());
  for (const Eigen::VectorXd& stretch : rates.values) {
    noise.seconds += noise.interval_s * static_cast<double>(stretch.size());
  }
  noise.curve = allan_curve(rates);
  if (noise.curve.empty()) return noise;
  noise.fit = fit_allan(noise.curve, rates);
  add_point(noise.curve, rates, kClusterSeconds);
  return noise;
}

/// Returns the summary of the noise. If the record has no hold, returns a note about that.
std::string summarise(const Dataset& dataset, const HoldNoise& noise, const char* bias, const char* caution) {
  return any_hold(dataset.segments) ? summarise(noise, bias, caution) : kNoHold;
}

HoldNoise measure_raw_noise(const Dataset& dataset, const Eigen::VectorXd& bias_deg_per_h) {
  HoldNoise noise = measure_noise(dataset, bias_deg_per_h);
  noise.statement = summarise(dataset, noise, "raw", "; remaining effects of temperature are part of B, K and R");
  return noise;
}

/// Returns the bias of the samples in one of the clusters and NaN elsewhere.
Eigen::VectorXd bias_in_clusters(const Dataset& dataset, const Clusters& clusters) {
  Eigen::VectorXd bias = Eigen::VectorXd::Constant(dataset.time_s.size(), kUnknown);
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < bias.size(); ++i) {
    while (k < clusters.start_s.size() && clusters.start_s(k) + clusters.length_s <= dataset.time_s(i)) ++k;
    if (k < clusters.start_s.size() && clusters.start_s(k) <= dataset.time_s(i)) bias(i) = dataset.bias_deg_per_h(i);
  }
  return bias;
}

}  // namespace

std::vector<double> fitted_deg_per_h(const HoldNoise& noise) {
  std::vector<double> fitted;
  for (const AllanPoint& point : noise.curve) fitted.push_back(noise_deviation(noise.fit, point.tau_s));
  return fitted;
}

NoiseFloor noise_floor(const Clusters& clusters, const std::vector<record::RunInfo::SegmentInfo>& segments,
                       double step_deg_per_h) {
  assert(clusters.last_segment.size() == clusters.segment.size());
  const auto is_wholly_inside = [&](Eigen::Index k) {
    return clusters.last_segment(k) == clusters.segment(k) ? clusters.segment(k) : -1;
  };
  SecondDifferences all;
  int used = 0;
  for (const Rows& hold : find_holds(clusters.start_s.size(), segments, is_wholly_inside)) {
    const int before = all.overlaps.differences;
    add_second_differences(all, clusters, hold);
    used += all.overlaps.differences > before ? 1 : 0;
  }
  const int differences = all.overlaps.differences;
  if (differences == 0) {
    const char* why = any_hold(segments) ? "no hold has three neighbouring means in its last hour" : kNoHold;
    return {.deg_per_h = kUnknown, .differences = 0, .error_deg_per_h = kUnknown, .statement = why};
  }
  NoiseFloor floor = floor_from(all, step_deg_per_h, clusters.length_s);
  floor.statement = fmt::format("Hadamard deviation at τ = {:g} s of the raw bias in the last hour of {}",
                                clusters.length_s, format_count(used, "hold"));
  return floor;
}

NoiseFloor residual_noise(const Clusters& clusters, const Eigen::VectorXd& residual_deg_per_h, double step_deg_per_h) {
  assert(residual_deg_per_h.size() == clusters.start_s.size());
  const Eigen::Index inner = std::max<Eigen::Index>(residual_deg_per_h.size() - 2, 0);
  Eigen::VectorXd differences = Eigen::VectorXd::Constant(inner, kUnknown);
  for (Eigen::Index k = 0; k < inner; ++k) {
    if (!are_neighbours(clusters, k) || !are_neighbours(clusters, k + 1)) continue;
    differences(k) = residual_deg_per_h(k + 2) - 2 * residual_deg_per_h(k + 1) + residual_deg_per_h(k);
  }
  const double limit = robust_limit(differences);
  const auto is_used = [&](Eigen::Index k) { return k < inner && std::abs(differences(k)) <= limit; };
  SecondDifferences all;
  for (Eigen::Index k = 0; k < inner; ++k) {
    if (!is_used(k)) continue;
    all.sum += differences(k) * differences(k);
    ++all.overlaps.differences;
    all.overlaps.by_two += is_used(k + 1) ? 1 : 0;
    all.overlaps.by_one += is_used(k + 2) ? 1 : 0;
  }
  if (all.overlaps.differences == 0)
    return {.deg_per_h = kUnknown, .error_deg_per_h = kUnknown, .statement = "no three neighbouring residuals"};
  NoiseFloor floor = floor_from(all, step_deg_per_h, clusters.length_s);
  floor.statement =
      fmt::format("Hadamard deviation at τ = {:g} s of the residual; the record has no hold", clusters.length_s);
  return floor;
}

bool has_hold(const Dataset& dataset) { return any_hold(dataset.segments); }

double expected_in_sample_std(const NoiseFloor& floor, double effective_parameters, int clusters) {
  const bool known = effective_parameters > 0 && effective_parameters < clusters;
  return known ? floor.deg_per_h * std::sqrt(1 - effective_parameters / clusters) : kUnknown;
}

std::optional<std::string> over_fit_warning(const Figures& residual, const NoiseFloor& floor,
                                            double effective_parameters) {
  constexpr double kCoverage = 2;
  const double residual_error = standard_error_of_std(residual);
  const double bar = kCoverage * std::hypot(std::isfinite(residual_error) ? residual_error : 0, floor.error_deg_per_h);
  if (!(residual.std < floor.deg_per_h - bar)) return std::nullopt;
  std::string text = fmt::format(
      "over-fit: the residual STD, {:.4g} °/h, is below the noise floor, {:.4g} °/h, by "
      "more than two standard errors of the difference, {:.2g} °/h",
      residual.std, floor.deg_per_h, bar);
  const double expected = expected_in_sample_std(floor, effective_parameters, residual.count);
  if (std::isfinite(expected)) {
    text += fmt::format("; {:.0f} effective parameters on {} clusters explain {:.4g} °/h", effective_parameters,
                        residual.count, expected);
  }
  return text;
}

HoldNoise measure_hold_noise(const Dataset& dataset) { return measure_raw_noise(dataset, dataset.bias_deg_per_h); }

HoldNoise measure_hold_noise(const Dataset& dataset, const Clusters& clusters) {
  return measure_raw_noise(dataset, bias_in_clusters(dataset, clusters));
}

HoldNoise measure_compensated_hold_noise(const Dataset& dataset, const Clusters& clusters,
                                         const Eigen::VectorXd& residual_deg_per_h) {
  assert(residual_deg_per_h.size() == clusters.bias_deg_per_h.size());
  const Eigen::VectorXd predicted = clusters.bias_deg_per_h - residual_deg_per_h;
  HoldNoise noise =
      measure_noise(dataset, dataset.bias_deg_per_h - interpolate_at_samples(dataset, clusters, predicted));
  noise.statement = summarise(dataset, noise, "compensated", "");
  return noise;
}

AllanCurve cluster_allan_curve(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters) {
  return allan_curve(cut_at_gaps(clusters.start_s, values, clusters.length_s));
}

}  // namespace gyrotherm::data
