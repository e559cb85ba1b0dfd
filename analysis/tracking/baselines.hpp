// SPDX-License-Identifier: Apache-2.0
/// What bias tracking is measured against: other ways to take noise from a rate that are in use for gyros, each with
/// what it says of the bias and how late.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "analysis/tracking/state_space.hpp"

namespace gyrotherm::tracking {

/// Rates with each missing one (NaN) replaced by the last one before it, or by 0: for what can do with no gap.
[[nodiscard]] Eigen::VectorXd without_gaps(const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h);

/// At place k the mean of the last `count` rates up to k, those that are there; 0 while there is none.
[[nodiscard]] Eigen::VectorXd trailing_means(const Eigen::Ref<const Eigen::VectorXd>& rates_deg_per_h,
                                             Eigen::Index count);

/// A forward linear predictor, ŷ(n) = Σ_{k=1}^{p} a_k y(n − k), whose weights follow by recursive least squares with
/// exponential forgetting (Haykin, Adaptive Filter Theory, 4th ed. 2002, chapter 9).
struct RecursivePrediction {
  Eigen::Index order = 36;    ///< p
  double forgetting = 0.999;  ///< λ, above 0, at most 1
};

/// ŷ(1) … ŷ(n), each by the values before it and one place earlier: place k holds the prediction of k + 1 by values up
/// to k. While fewer than p values are known it is their mean. The weights start at 1/p, the mean of the last p, held
/// there as firmly as p values of the mean square of the first p would hold them. All values are finite.
[[nodiscard]] Eigen::VectorXd predicted_next(const Eigen::Ref<const Eigen::VectorXd>& values,
                                             const RecursivePrediction& options = {});

// Wavelet shrinkage with the four-tap filter of Daubechies, for whole sequences and for windows of the past.

/// One level of the periodic transform (Daubechies, Comm. Pure Appl. Math. 41 (1988) 909; two vanishing moments): of an
/// even number of values, the approximations in the first half and the details in the second. Orthogonal.
[[nodiscard]] Eigen::VectorXd wavelet_step(const Eigen::Ref<const Eigen::VectorXd>& values);
/// Its inverse.
[[nodiscard]] Eigen::VectorXd wavelet_step_back(const Eigen::Ref<const Eigen::VectorXd>& coefficients);

/// Denoises by soft thresholds (Donoho and Johnstone, Biometrika 81 (1994) 425): every detail d becomes sign(d)
/// max(|d| − t, 0), t = σ√(2 ln n), n values, σ the median magnitude of the finest details over 0.6745. The values, all
/// finite and at least one, are continued by their mirror image to a power of two and then back to their beginning, so
/// that no jump is made at an end. The approximations that are left alone are means over about a quarter of that.
[[nodiscard]] Eigen::VectorXd wavelet_denoised(const Eigen::Ref<const Eigen::VectorXd>& values);

/// The same as it can be had while values come: at place k the value of k − delay in the denoised window of the last
/// `window` values up to k; NaN for the first `delay` places. The window is longer than the delay.
[[nodiscard]] Eigen::VectorXd wavelet_denoised_in_windows(const Eigen::Ref<const Eigen::VectorXd>& values,
                                                          Eigen::Index window, Eigen::Index delay);

/// What a denoiser says of a bias, at each place k by the rates up to k; NaN while it says nothing.
struct Denoised {
  Eigen::VectorXd bias;       ///< of the interval k − latency
  Eigen::VectorXd next_hour;  ///< mean over the hour that follows k; NaN of one that is late
};

/// One way to take noise from a sequence of rates, NaN where one is missing.
struct Denoiser {
  std::string name;
  Eigen::Index latency{};  ///< intervals from the one that it speaks of to the one at whose end it does
  std::function<Denoised(const Eigen::VectorXd& rates_deg_per_h)> denoise;
};

/// The denoisers that are compared: none at all (the thermal model alone); the mean so far and that of the last hour;
/// forward linear prediction by normalised least mean squares (methods::forward_prediction, order 8) and by recursive
/// least squares; wavelets in windows of 256 intervals, at once and an hour late; the Kalman filter, at once and an
/// hour late. Of those that answer at once, all but the Kalman filter foretell the next hour by holding what they said
/// last.
[[nodiscard]] std::vector<Denoiser> denoisers(const StateSpace& space);

/// How many intervals an hour has, at least 1.
[[nodiscard]] Eigen::Index intervals_of_hour(double interval_s);

}  // namespace gyrotherm::tracking
