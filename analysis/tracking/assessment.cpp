// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/assessment.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <random>

#include "analysis/data/allan.hpp"
#include "analysis/data/distributions.hpp"
#include "analysis/tracking/baselines.hpp"
#include "analysis/tracking/smoothing.hpp"
#include "core/quantity.hpp"
#include "core/random.hpp"

namespace gyrotherm::tracking {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kSettlingHours = 2;

/// Accumulator of the root mean square. NaN without values.
struct RootMeanSquare {
  double sum{};
  int count{};
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value * value;
    ++count;
  }
  void add(const RootMeanSquare& more) {
    sum += more.sum;
    count += more.count;
  }
  [[nodiscard]] double value() const { return count > 0 ? std::sqrt(sum / count) : kNothing; }
};

/// Returns at index k the mean of the following `hour` values. NaN if one of them is missing.
Eigen::VectorXd next_hour_means(const Eigen::VectorXd& values, Eigen::Index hour) {
  Eigen::VectorXd means = Eigen::VectorXd::Constant(values.size(), kNothing);
  for (Eigen::Index k = 0; k + hour < values.size(); ++k) means(k) = values.segment(k + 1, hour).mean();
  return means;
}

/// Computes the errors of a denoiser's forecasts for the hours of `values`.
RootMeanSquare forecast_errors(const DenoiserOutput& denoised, const Eigen::VectorXd& values, Eigen::Index hour) {
  RootMeanSquare errors;
  const Eigen::VectorXd means = next_hour_means(values, hour);
  for (Eigen::Index k = kSettlingHours * hour; k < values.size(); ++k) errors.add(denoised.next_hour(k) - means(k));
  return errors;
}

double rmse_to_truth(const DenoiserOutput& denoised, const Eigen::VectorXd& truth, const Denoiser& denoiser,
                     Eigen::Index hour) {
  RootMeanSquare errors;
  const Eigen::Index first = std::max(denoiser.latency, kSettlingHours * hour);
  for (Eigen::Index k = first; k < truth.size(); ++k) errors.add(denoised.bias(k) - truth(k - denoiser.latency));
  return errors.value();
}

/// Returns the standard error of an RMSE of forecasts made in every interval. Forecasts of overlapping hours share
/// values, so the number of independent forecasts is the number of whole hours.
double standard_error(const RootMeanSquare& errors, Eigen::Index hour) {
  const auto whole_hours = errors.count / hour;
  return whole_hours > 0 ? errors.value() / std::sqrt(2.0 * static_cast<double>(whole_hours)) : kNothing;
}

/// Shuffles the values that are not missing and subtracts their mean.
Eigen::VectorXd shuffle_values(const Eigen::VectorXd& values, std::uint64_t seed) {
  std::vector<Eigen::Index> indices;
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (std::isfinite(values(k))) indices.push_back(k);
  }
  Eigen::VectorXd mixed = values;
  std::mt19937_64 random(seed);
  for (std::size_t remaining = indices.size(); remaining > 1; --remaining) {
    const auto other = static_cast<std::size_t>(draw_index(static_cast<std::int64_t>(remaining), random));
    std::swap(mixed(indices[remaining - 1]), mixed(indices[other]));
  }
  if (!indices.empty()) mixed.array() -= values(indices).mean();
  return mixed;
}

double shuffled_gain(const Denoiser& denoiser, const Eigen::VectorXd& residual, Eigen::Index hour) {
  constexpr std::uint64_t kShuffles = 8;
  RootMeanSquare denoised_errors, none;
  for (std::uint64_t seed = 1; seed <= kShuffles; ++seed) {
    const Eigen::VectorXd values = shuffle_values(residual, seed);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(values.size());
    denoised_errors.add(forecast_errors(denoiser.denoise(values), values, hour));
    none.add(forecast_errors({zero, zero}, values, hour));
  }
  return 1 - denoised_errors.value() / none.value();
}

/// Returns the residual minus the bias estimate of the previous interval.
Eigen::VectorXd residual_rate(const Eigen::VectorXd& residual, const DenoiserOutput& denoised) {
  Eigen::VectorXd remaining = residual;
  for (Eigen::Index k = 1; k < remaining.size(); ++k) remaining(k) -= denoised.bias(k - 1);
  return remaining;
}

double allan_deviation(const Eigen::VectorXd& rates, double interval_s, Eigen::Index intervals) {
  const auto count = rates.size();
  const Eigen::VectorXd time_s = interval_s * Eigen::VectorXd::LinSpaced(count, 0, static_cast<double>(count - 1));
  const auto stretches = data::cut_at_gaps(time_s, rates, interval_s);
  const bool enough =
      std::ranges::any_of(stretches.values, [&](const auto& stretch) { return stretch.size() >= 2 * intervals; });
  return enough ? data::allan_point(stretches, static_cast<int>(intervals)).deviation_deg_per_h : kNothing;
}

/// Returns the response of a denoiser to noise with a change, minus its response to the same noise without the change.
Eigen::VectorXd change_response(const Denoiser& denoiser, const Eigen::VectorXd& noise, const Eigen::VectorXd& change) {
  return denoiser.denoise(noise + change).bias - denoiser.denoise(noise).bias;
}

/// Scales the values by a power of 2, which keeps the square of the greatest value representable. Correlations are
/// bit-identical.
Eigen::VectorXd scale_to_unit(const Eigen::Ref<const Eigen::VectorXd>& values) {
  double greatest = 0;
  for (const double value : values)
    if (std::isfinite(value)) greatest = std::max(greatest, std::abs(value));
  if (greatest == 0) return values;
  const int exponent = std::ilogb(greatest);
  return values.unaryExpr([exponent](double value) { return std::scalbn(value, -exponent); });
}

}  // namespace

Whiteness test_whiteness(const Eigen::Ref<const Eigen::VectorXd>& values, int lags) {
  assert(lags >= 1);
  Whiteness whiteness{.lags = lags, .probability = kNothing};
  const Eigen::VectorXd scaled = scale_to_unit(values);
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

Consistency test_consistency(const std::vector<TrackedInterval>& intervals, std::size_t settling) {
  constexpr int kLags = 20;
  Consistency consistency{.mean_square = kNothing, .low = kNothing, .high = kNothing};
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
  consistency.whiteness = test_whiteness(normalised, kLags);
  if (consistency.innovations == 0) return consistency;
  constexpr double kTwoSided95 = 1.959963985;
  const double bar = kTwoSided95 * std::sqrt(2.0 / consistency.innovations);
  consistency.mean_square = sum / consistency.innovations;
  consistency.low = 1 - bar;
  consistency.high = 1 + bar;
  return consistency;
}

Eigen::VectorXd space_evenly(const Eigen::Ref<const Eigen::VectorXd>& values, const data::Clusters& clusters) {
  assert(values.size() == clusters.start_s.size());
  if (values.size() == 0) return {};
  const auto index = [&](Eigen::Index k) {
    return static_cast<Eigen::Index>(std::llround((clusters.start_s(k) - clusters.start_s(0)) / clusters.length_s));
  };
  Eigen::VectorXd spaced = Eigen::VectorXd::Constant(index(values.size() - 1) + 1, kNothing);
  for (Eigen::Index k = 0; k < values.size(); ++k) spaced(index(k)) = values(k);
  return spaced;
}

Response measure_response(const Denoiser& denoiser, const StateSpace& space) {
  constexpr double kStep = 1, kRounding = 1e-9, kSlopePerHour = 0.6;  // 0.01 °/h/min
  constexpr Eigen::Index kDay = 24, kRampHours = 6;
  const Eigen::Index hour = intervals_per_hour(space.interval_s), begin = kDay * hour, count = 2 * begin;
  std::mt19937_64 random(1);
  const Eigen::VectorXd noise = draw(space, count, random).measured_deg_per_h;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(count), ramp = step;
  step.tail(count - begin).setConstant(kStep);
  const double rise = kSlopePerHour * space.interval_s / kSecondsPerHour;  // per interval
  for (Eigen::Index k = begin; k < count; ++k) {
    ramp(k) = rise * (static_cast<double>(std::min(k - begin, kRampHours * hour)) + 0.5);
  }
  const Eigen::VectorXd step_response = change_response(denoiser, noise, step),
                        ramp_response = change_response(denoiser, noise, ramp);
  Response response{.step_delay_s = kNothing};
  for (Eigen::Index k = count - 1; k >= begin; --k) {
    if (step_response(k) >= kStep / 2 - kRounding)
      response.step_delay_s = static_cast<double>(k + 1 - begin) * space.interval_s;
  }
  const Eigen::Index end = begin + kRampHours * hour;
  response.step_overshoot = std::max(0.0, step_response.tail(count - begin).maxCoeff() / kStep - 1);
  response.ramp_delay_s = (ramp(end) - ramp_response(end)) / kSlopePerHour * kSecondsPerHour;
  response.ramp_overshoot_deg_per_h = std::max(0.0, ramp_response.tail(count - begin).maxCoeff() - ramp(end));
  return response;
}

TrackedSeries make_series(const BiasNoise& noise, const Eigen::VectorXd& residual_deg_per_h, double interval_s) {
  const StateSpace space = state_space(noise, interval_s);
  const auto numbers = [](const Eigen::VectorXd& values) { return std::vector<double>(values.begin(), values.end()); };
  const SmoothedBias smoothed = smooth(space, residual_deg_per_h);
  TrackedSeries series{.residual = numbers(residual_deg_per_h),
                       .predicted = {},
                       .smoothed = numbers(smoothed.deg_per_h),
                       .smoothed_std = numbers(smoothed.std_deg_per_h)};
  for (const TrackedInterval& interval : track(space, residual_deg_per_h)) {
    series.predicted.push_back(interval.predicted.sum());
  }
  return series;
}

Assessment assess(const BiasNoise& noise, const Eigen::VectorXd& residual_deg_per_h, double interval_s,
                  const Eigen::VectorXd& true_bias_deg_per_h) {
  const Eigen::VectorXd& truth = true_bias_deg_per_h;
  assert(truth.size() == 0 || truth.size() == residual_deg_per_h.size());
  const StateSpace space = state_space(noise, interval_s);
  const Eigen::Index hour = intervals_per_hour(interval_s);
  Assessment assessment{.noise = noise,
                        .interval_s = interval_s,
                        .steady_gain = steady_state(space).gain.sum(),
                        .denoisers = {},
                        .series = {}};
  for (const Denoiser& denoiser : denoisers(space)) {
    const DenoiserOutput denoised = denoiser.denoise(residual_deg_per_h);
    const RootMeanSquare errors = forecast_errors(denoised, residual_deg_per_h, hour);
    assessment.hours = std::max(assessment.hours, errors.count / static_cast<int>(hour));
    const Eigen::VectorXd residual_rates = residual_rate(residual_deg_per_h, denoised);
    assessment.denoisers.push_back(
        {.name = denoiser.name,
         .latency_s = static_cast<double>(denoiser.latency) * interval_s,
         .next_hour_rmse = errors.value(),
         .next_hour_rmse_error = standard_error(errors, hour),
         .next_hour_rmse_to_truth = forecast_errors(denoised, truth, hour).value(),
         .rmse_to_truth = rmse_to_truth(denoised, truth, denoiser, hour),
         .shuffled_gain = shuffled_gain(denoiser, residual_deg_per_h, hour),
         .allan_interval = denoiser.latency > 0 ? kNothing : allan_deviation(residual_rates, interval_s, 1),
         .allan_hour = denoiser.latency > 0 ? kNothing : allan_deviation(residual_rates, interval_s, hour),
         .response = measure_response(denoiser, space)});
  }
  assessment.series = make_series(noise, residual_deg_per_h, interval_s);
  assessment.consistency = test_consistency(track(space, residual_deg_per_h), kSettlingHours * hour);
  return assessment;
}

}  // namespace gyrotherm::tracking
