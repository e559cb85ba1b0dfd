// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/baselines.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "analysis/methods/svr.hpp"
#include "analysis/tracking/bias_tracker.hpp"
#include "analysis/tracking/smoothing.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::tracking {
namespace {

/// Returns at index k the prediction of value k + 1 by normalised least mean squares.
Eigen::VectorXd predict_by_least_mean_squares(const Eigen::VectorXd& values) {
  const Eigen::Index count = values.size();
  const methods::ForwardPrediction options;
  // The last element is predicted and not used for adaptation.
  Eigen::VectorXd longer(count + 1);
  longer << values, 0;
  Eigen::VectorXd next = trailing_means(values, options.order);
  const Eigen::VectorXd predicted = methods::forward_prediction(longer, options);
  for (Eigen::Index k = options.order - 1; k < count; ++k) next(k) = predicted(k + 1);
  return next;
}

DenoiserOutput use_as_forecast(const Eigen::VectorXd& bias) { return {bias, bias}; }
DenoiserOutput omit_forecast(const Eigen::VectorXd& bias) {
  return {bias, Eigen::VectorXd::Constant(bias.size(), std::numeric_limits<double>::quiet_NaN())};
}

DenoiserOutput run_kalman_filter(const StateSpace& space, const Eigen::VectorXd& rates) {
  const auto hour = static_cast<int>(intervals_per_hour(space.interval_s));
  BiasTracker tracker(space);
  DenoiserOutput denoised{Eigen::VectorXd(rates.size()), Eigen::VectorXd(rates.size())};
  for (Eigen::Index k = 0; k < rates.size(); ++k) {
    tracker.push(rates(k));
    denoised.bias(k) = tracker.estimate().deg_per_h;
    denoised.next_hour(k) = tracker.forecast(hour).deg_per_h;
  }
  return denoised;
}

constexpr Eigen::Index kTaps = 4;

/// (1 + √3, 3 + √3, 3 − √3, 1 − √3)/(4√2).
constexpr std::array<double, kTaps> kLow = {0.48296291314453414, 0.83651630373780790, 0.22414386804201339,
                                            -0.12940952255126037};
constexpr std::array<double, kTaps> kHigh = {kLow[3], -kLow[2], kLow[1], -kLow[0]};

/// Maps index `i` of the repeated mirror extension of `count` values to an index of these values.
Eigen::Index mirror_index(Eigen::Index i, Eigen::Index count) {
  const Eigen::Index there = i % (2 * count);
  return there < count ? there : 2 * count - 1 - there;
}

double median_magnitude(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Eigen::VectorXd magnitudes = values.cwiseAbs();
  auto* middle = magnitudes.data() + magnitudes.size() / 2;
  std::nth_element(magnitudes.data(), middle, magnitudes.data() + magnitudes.size());
  return *middle;
}

/// Returns the smallest power of two that is at least `count` and at least 8.
Eigen::Index power_of_two(Eigen::Index count) {
  Eigen::Index power = 8;
  while (power < count) power *= 2;
  return power;
}

}  // namespace

Eigen::Index intervals_per_hour(double interval_s) {
  return std::max<Eigen::Index>(1, std::lround(kSecondsPerHour / interval_s));
}

Eigen::VectorXd fill_gaps(const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h) {
  Eigen::VectorXd rates = rates_deg_per_h;
  double last = 0;
  for (double& rate : rates) last = rate = std::isfinite(rate) ? rate : last;
  return rates;
}

Eigen::VectorXd trailing_means(const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h, Eigen::Index count) {
  assert(count >= 1);
  const Eigen::Index size = rates_deg_per_h.size();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(size + 1), counts = sums, means(size);
  for (Eigen::Index k = 0; k < size; ++k) {
    const bool there = std::isfinite(rates_deg_per_h(k));
    sums(k + 1) = sums(k) + (there ? rates_deg_per_h(k) : 0);
    counts(k + 1) = counts(k) + (there ? 1 : 0);
    const Eigen::Index before = std::max<Eigen::Index>(0, k + 1 - count);
    const double seen = counts(k + 1) - counts(before);
    means(k) = seen > 0 ? (sums(k + 1) - sums(before)) / seen : 0;
  }
  return means;
}

Eigen::VectorXd predict_next(const Eigen::Ref<const Eigen::VectorXd>& values, const RecursivePrediction& options) {
  assert(options.order >= 1 && options.forgetting > 0 && options.forgetting <= 1 && values.allFinite());
  const Eigen::Index order = options.order;
  Eigen::VectorXd next = trailing_means(values, order);
  if (values.size() <= order) return next;
  const double power = values.head(order).squaredNorm();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(order, order) / (power > 0 ? power : 1);
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(order, 1 / static_cast<double>(order));
  for (Eigen::Index k = order; k < values.size(); ++k) {
    const Eigen::VectorXd before = values.segment(k - order, order).reverse();
    const Eigen::VectorXd reach = inverse * before;
    const Eigen::VectorXd gain = reach / (options.forgetting + before.dot(reach));
    weights += gain * (values(k) - weights.dot(before));
    inverse = ((inverse - gain * reach.transpose()) / options.forgetting).eval();
    inverse = (0.5 * (inverse + inverse.transpose())).eval();
    next(k) = weights.dot(values.segment(k - order + 1, order).reverse());
  }
  return next;
}

Eigen::VectorXd wavelet_step(const Eigen::Ref<const Eigen::VectorXd>& values) {
  const Eigen::Index half = values.size() / 2;
  assert(values.size() == 2 * half && values.size() >= kTaps);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(values.size());
  for (Eigen::Index i = 0; i < half; ++i) {
    for (Eigen::Index tap = 0; tap < kTaps; ++tap) {
      const double value = values((2 * i + tap) % values.size());
      coefficients(i) += kLow[static_cast<std::size_t>(tap)] * value;
      coefficients(half + i) += kHigh[static_cast<std::size_t>(tap)] * value;
    }
  }
  return coefficients;
}

Eigen::VectorXd wavelet_step_back(const Eigen::Ref<const Eigen::VectorXd>& coefficients) {
  const Eigen::Index half = coefficients.size() / 2;
  assert(coefficients.size() == 2 * half && coefficients.size() >= kTaps);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(coefficients.size());
  for (Eigen::Index i = 0; i < half; ++i) {
    for (Eigen::Index tap = 0; tap < kTaps; ++tap) {
      values((2 * i + tap) % values.size()) += kLow[static_cast<std::size_t>(tap)] * coefficients(i) +
                                               kHigh[static_cast<std::size_t>(tap)] * coefficients(half + i);
    }
  }
  return values;
}

Eigen::VectorXd wavelet_denoised(const Eigen::Ref<const Eigen::VectorXd>& values) {
  constexpr double kMedianOfNormal = 0.6745;
  constexpr Eigen::Index kCoarsestLength = 8;  // approximations of the extended sequence
  const Eigen::Index count = values.size(), held = power_of_two(count);
  assert(count >= 1 && values.allFinite());
  Eigen::VectorXd all(2 * held);
  for (Eigen::Index i = 0; i < all.size(); ++i) all(i) = values(mirror_index(mirror_index(i, held), count));
  double threshold = 0;
  for (Eigen::Index length = all.size(); length > kCoarsestLength; length /= 2) {
    all.head(length) = wavelet_step(all.head(length));
    auto details = all.segment(length / 2, length / 2);
    if (length == all.size()) {
      threshold = median_magnitude(details) / kMedianOfNormal * std::sqrt(2 * std::log(static_cast<double>(count)));
    }
    details = details.array().sign() * (details.array().abs() - threshold).max(0.0);
  }
  for (Eigen::Index length = 2 * kCoarsestLength; length <= all.size(); length *= 2) {
    all.head(length) = wavelet_step_back(all.head(length));
  }
  return all.head(count);
}

Eigen::VectorXd wavelet_denoised_in_windows(const Eigen::Ref<const Eigen::VectorXd>& values, Eigen::Index window,
                                            Eigen::Index delay) {
  assert(0 <= delay && delay < window);
  Eigen::VectorXd denoised = Eigen::VectorXd::Constant(values.size(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = delay; k < values.size(); ++k) {
    const Eigen::Index length = std::min(window, k + 1);
    denoised(k) = wavelet_denoised(values.segment(k + 1 - length, length))(length - 1 - delay);
  }
  return denoised;
}

std::vector<Denoiser> denoisers(const StateSpace& space) {
  constexpr Eigen::Index kWindow = 256;
  const Eigen::Index hour = intervals_per_hour(space.interval_s);
  const auto wavelet = [](Eigen::Index delay) {
    return [delay](const Eigen::VectorXd& rates) {
      const Eigen::VectorXd bias = wavelet_denoised_in_windows(fill_gaps(rates), kWindow, delay);
      return delay > 0 ? omit_forecast(bias) : use_as_forecast(bias);
    };
  };
  std::vector<Denoiser> all;
  all.push_back({"thermal model alone", 0,
                 [](const Eigen::VectorXd& rates) { return use_as_forecast(Eigen::VectorXd::Zero(rates.size())); }});
  all.push_back({"mean so far", 0, [](const Eigen::VectorXd& rates) {
                   return use_as_forecast(trailing_means(rates, std::max<Eigen::Index>(1, rates.size())));
                 }});
  all.push_back({"mean of the last hour", 0,
                 [hour](const Eigen::VectorXd& rates) { return use_as_forecast(trailing_means(rates, hour)); }});
  all.push_back({"linear prediction, LMS", 0, [](const Eigen::VectorXd& rates) {
                   return use_as_forecast(predict_by_least_mean_squares(fill_gaps(rates)));
                 }});
  all.push_back({"linear prediction, RLS", 0,
                 [](const Eigen::VectorXd& rates) { return use_as_forecast(predict_next(fill_gaps(rates))); }});
  all.push_back({"wavelet, at once", 0, wavelet(0)});
  if (hour < kWindow) all.push_back({"wavelet, an hour late", hour, wavelet(hour)});
  all.push_back({"Kalman", 0, [space](const Eigen::VectorXd& rates) { return run_kalman_filter(space, rates); }});
  all.push_back({"Kalman, an hour late", hour, [space, hour](const Eigen::VectorXd& rates) {
                   return omit_forecast(smooth_with_lag(space, rates, hour));
                 }});
  return all;
}

}  // namespace gyrotherm::tracking
