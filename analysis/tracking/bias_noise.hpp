// SPDX-License-Identifier: Apache-2.0
/// Noise model of the residual bias of a thermal model. It has only the parameters that bias tracking needs, and is
/// estimated from a residual.
#pragma once

#include <Eigen/Core>

#include "analysis/data/clusters.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::tracking {

/// Noise coefficients in the notation of IEEE Std 952 (allan.hpp), each at least 0.
struct BiasNoise {
  double angle_random_walk_deg_per_sqrt_h{};       ///< N, above 0
  double instability_deg_per_h{};                  ///< B
  double rate_random_walk_deg_per_h_per_sqrt_h{};  ///< K
  /// Standard deviation of the bias at the start of tracking.
  double start_deg_per_h{};
};

void describe(auto& form, Like<BiasNoise> auto& noise) {
  form("angle_random_walk_deg_per_sqrt_h", positive(noise.angle_random_walk_deg_per_sqrt_h));
  form("instability_deg_per_h", not_negative(noise.instability_deg_per_h));
  form("rate_random_walk_deg_per_h_per_sqrt_h", not_negative(noise.rate_random_walk_deg_per_h_per_sqrt_h));
  form("start_deg_per_h", not_negative(noise.start_deg_per_h));
}

/// Estimates the noise of a residual bias from the Allan deviation of its cluster means over whole records including
/// ramps. The noise model must cover both the drift of the gyro itself and the errors of the thermal model. Pass the
/// held-out residual; an in-sample residual does not contain the part that the fit absorbed. Only N, B and K are fitted
/// (allan.hpp); a term that is not significant is 0. Quantisation is not fitted, because means over 100 s cannot
/// separate it from N. The rate ramp is not fitted, because it does not continue after the record.
///
/// If N is not significant because the errors of the model are larger, N is computed from `floor_deg_per_h`, the noise
/// floor of the record: the white noise of one mean (NaN: unknown). The initial uncertainty of the bias is the RMS of
/// the residual. Fails with usage if there are fewer than five averaging times, or if both sources of N are missing.
[[nodiscard]] Result<BiasNoise> estimate_bias_noise(const Eigen::Ref<const Eigen::VectorXd>& residual_deg_per_h,
                                                    const data::Clusters& clusters, double floor_deg_per_h);

}  // namespace gyrotherm::tracking
