// SPDX-License-Identifier: Apache-2.0
/// Denoisers with which bias tracking is compared: other methods that remove noise from the rate of a gyro. Each
/// returns a bias estimate and has a latency.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "analysis/tracking/state_space.hpp"

namespace gyrotherm::tracking {

/// Replaces each missing rate (NaN) by the previous rate, or by 0, for methods that require data without gaps.
[[nodiscard]] Eigen::VectorXd fill_gaps(const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h);

/// Returns at index k the mean of the last `count` rates up to k. Ignores missing rates. The mean is 0 if all are
/// missing.
[[nodiscard]] Eigen::VectorXd trailing_means(const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h,
                                             Eigen::Index count);

/// Options of a forward linear predictor, ŷ(n) = Σ_{k=1}^{p} a_k y(n − k). Its weights are adapted by recursive least
/// squares with exponential forgetting (Haykin, Adaptive Filter Theory, 4th ed. 2002, chapter 9).
struct RecursivePrediction {
  Eigen::Index order = 36;    ///< p
  double forgetting = 0.999;  ///< λ, 0 < λ ≤ 1
};

/// Predicts each next value from the previous ones: index k holds the prediction of value k + 1 from values up to k.
/// While fewer than p values are known, the prediction is their mean. All weights start at 1/p, which predicts the mean
/// of the last p values. The initial weights count as much as p values with the mean square of the first p values. All
/// values must be finite.
[[nodiscard]] Eigen::VectorXd predict_next(const Eigen::Ref<const Eigen::VectorXd>& values,
                                           const RecursivePrediction& options = {});

// Wavelet shrinkage with the four-tap filter of Daubechies, for whole sequences and for windows of past values.

/// Computes one level of the periodic transform (Daubechies, Comm. Pure Appl. Math. 41 (1988) 909; two vanishing
/// moments). The number of values must be even. The first half of the result are the approximations, the second half
/// the details. The transform is orthogonal.
[[nodiscard]] Eigen::VectorXd wavelet_step(const Eigen::Ref<const Eigen::VectorXd>& values);
/// Computes the inverse transform.
[[nodiscard]] Eigen::VectorXd wavelet_step_back(const Eigen::Ref<const Eigen::VectorXd>& coefficients);

/// Denoises by soft thresholds (Donoho and Johnstone, Biometrika 81 (1994) 425). Every detail d becomes sign(d) max(|d|
/// − t, 0), t = σ√(2 ln n) for n values, σ the median magnitude of the finest details divided by 0.6745. There must be
/// at least one value, and all must be finite. To avoid jumps at the ends, the values are extended by their mirror
/// image to a power of two, and the extended sequence is mirrored again. The coarsest approximations remain unchanged;
/// each is a mean over about a quarter of the power of two.
[[nodiscard]] Eigen::VectorXd wavelet_denoised(const Eigen::Ref<const Eigen::VectorXd>& values);

/// Denoises a sequence causally. Index k holds the denoised value k − delay, computed from the last `window` values up
/// to k. NaN for the first `delay` indices. The window must be longer than the delay.
[[nodiscard]] Eigen::VectorXd wavelet_denoised_in_windows(const Eigen::Ref<const Eigen::VectorXd>& values,
                                                          Eigen::Index window, Eigen::Index delay);

/// Output of a denoiser. Index k uses the rates up to k; NaN where there is no estimate.
struct DenoiserOutput {
  /// Bias estimate for interval k − latency.
  Eigen::VectorXd bias;
  /// Forecast of the mean over the hour after k. NaN for a denoiser with latency.
  Eigen::VectorXd next_hour;
};

/// Denoiser of a sequence of rates. Missing rates are NaN.
struct Denoiser {
  std::string name;
  /// Delay of the estimates in intervals: at interval k the denoiser estimates the bias of interval k − latency.
  Eigen::Index latency{};
  std::function<DenoiserOutput(const Eigen::VectorXd& rates_deg_per_h)> denoise;
};

/// Returns the compared denoisers: none (the thermal model alone); the mean so far and the mean of the last hour;
/// forward linear prediction by normalised least mean squares (methods::forward_prediction, order 8) and by recursive
/// least squares; wavelets in windows of 256 intervals, without delay and with a delay of one hour; the Kalman filter,
/// without delay and with a delay of one hour. Denoisers without delay, except the Kalman filter, use their last
/// estimate as the forecast of the next hour.
[[nodiscard]] std::vector<Denoiser> denoisers(const StateSpace& space);

/// Returns the number of intervals per hour, at least 1.
[[nodiscard]] Eigen::Index intervals_per_hour(double interval_s);

}  // namespace gyrotherm::tracking
