// SPDX-License-Identifier: Apache-2.0
/// Wavelet shrinkage with the four-tap filter of Daubechies, for whole sequences and for windows of the past.
#pragma once

#include <Eigen/Core>

namespace gyrotherm::tracking {

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

}  // namespace gyrotherm::tracking
