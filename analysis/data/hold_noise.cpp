#include "analysis/data/hold_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "analysis/data/noise_floor.hpp"

namespace gyrotherm {
namespace {

/// Samples first … first + count − 1.
struct Rows {
  Eigen::Index first{}, count{};
};

/// The samples of each hold; of one segment twice if it is left and entered again.
std::vector<Rows> holds_of(const Dataset& dataset) {
  const Eigen::Index rows = dataset.time_s.size();
  if (dataset.segments.empty()) return rows > 0 ? std::vector<Rows>{{0, rows}} : std::vector<Rows>{};
  std::vector<Rows> holds;
  int open = -1;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const int segment = dataset.segment(k);
    const bool inside = segment >= 0 && dataset.segments[static_cast<std::size_t>(segment)].hold;
    if (inside && segment != open) holds.push_back({k, 0});
    if (inside) ++holds.back().count;
    open = inside ? segment : -1;
  }
  return holds;
}

Rows last_hour(const Dataset& dataset, const Rows& hold, double interval_s) {
  const Eigen::Index end = hold.first + hold.count;
  const double from_s = dataset.time_s(end - 1) + interval_s - kQuietSeconds;
  Eigen::Index first = hold.first;
  while (dataset.time_s(first) < from_s - 0.5 * interval_s) ++first;
  return {first, end - first};
}

/// 1 s, or the median step of a foreign record.
double interval_of(const Dataset& dataset) {
  if (!dataset.imported || dataset.time_s.size() < 2) return 1;
  const Eigen::Index steps = dataset.time_s.size() - 1;
  Eigen::VectorXd step = dataset.time_s.tail(steps) - dataset.time_s.head(steps);
  std::nth_element(step.begin(), step.begin() + steps / 2, step.end());
  return step(steps / 2);
}

AllanFit nothing_seen() {
  AllanFit fit;
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    fit.coefficients[k] = {.term = static_cast<NoiseTerm>(k), .at_most = std::numeric_limits<double>::quiet_NaN()};
  }
  return fit;
}

/// The prediction at each sample: straight lines between the middles of neighbouring clusters, NaN elsewhere.
Eigen::VectorXd at_samples(const Dataset& dataset, const Clusters& clusters, const Eigen::VectorXd& predicted) {
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

std::string statement_of(const HoldNoise& noise, const char* bias, const char* caution) {
  if (noise.curve.empty()) return "no hold has samples enough without a gap";
  return fmt::format(
      "{} bias, one sample each {:g} s, in the last hour of {} hold{}: {} stretch{} without a gap, {:.0f} "
      "s in all{}",
      bias, noise.interval_s, noise.holds, noise.holds == 1 ? "" : "s", noise.stretches,
      noise.stretches == 1 ? "" : "es", noise.seconds, caution);
}

HoldNoise noise_of(const Dataset& dataset, const Eigen::VectorXd& bias_deg_per_h) {
  HoldNoise noise{.curve = {}, .fit = nothing_seen(), .statement = {}};
  noise.interval_s = interval_of(dataset);
  RateStretches rates{.interval_s = noise.interval_s, .values = {}};
  for (const Rows& hold : noise.interval_s > 0 ? holds_of(dataset) : std::vector<Rows>{}) {
    const Rows hour = last_hour(dataset, hold, noise.interval_s);
    RateStretches of_hold = cut_at_gaps(dataset.time_s.segment(hour.first, hour.count),
                                        bias_deg_per_h.segment(hour.first, hour.count), noise.interval_s);
    noise.holds += of_hold.values.empty() ? 0 : 1;
    std::ranges::move(of_hold.values, std::back_inserter(rates.values));
  }
  noise.stretches = static_cast<int>(rates.values.size());
  for (const Eigen::VectorXd& stretch : rates.values) {
    noise.seconds += noise.interval_s * static_cast<double>(stretch.size());
  }
  noise.curve = allan_curve(rates);
  if (!noise.curve.empty()) noise.fit = fit_allan(noise.curve, rates);
  return noise;
}

}  // namespace

HoldNoise noise_of_holds(const Dataset& dataset) {
  HoldNoise noise = noise_of(dataset, dataset.bias_deg_per_h);
  noise.statement = statement_of(noise, "raw", "; what the temperature still does there is part of B, K and R");
  return noise;
}

HoldNoise noise_of_compensated_holds(const Dataset& dataset, const Clusters& clusters,
                                     const Eigen::VectorXd& residual_deg_per_h) {
  assert(residual_deg_per_h.size() == clusters.bias_deg_per_h.size());
  const Eigen::VectorXd predicted = clusters.bias_deg_per_h - residual_deg_per_h;
  HoldNoise noise = noise_of(dataset, dataset.bias_deg_per_h - at_samples(dataset, clusters, predicted));
  noise.statement = statement_of(noise, "compensated", "");
  return noise;
}

AllanCurve allan_curve_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters) {
  return allan_curve(cut_at_gaps(clusters.start_s, values, clusters.length_s));
}

}  // namespace gyrotherm
