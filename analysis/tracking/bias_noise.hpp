// SPDX-License-Identifier: Apache-2.0
/// How the bias that a thermal model leaves wanders, in the few numbers that bias tracking needs, and how they are read
/// from a residual.
#pragma once

#include <Eigen/Core>

#include "analysis/data/clusters.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::tracking {

/// Noise coefficients as IEEE Std 952 writes them (allan.hpp), each 0 or more.
struct BiasNoise {
  double angle_random_walk_deg_per_sqrt_h{};       ///< N, above 0
  double instability_deg_per_h{};                  ///< B
  double rate_random_walk_deg_per_h_per_sqrt_h{};  ///< K
  double start_deg_per_h{};                        ///< standard deviation of the bias where tracking begins
};

void describe(auto& form, Like<BiasNoise> auto& noise) {
  form("angle_random_walk_deg_per_sqrt_h", positive(noise.angle_random_walk_deg_per_sqrt_h));
  form("instability_deg_per_h", not_negative(noise.instability_deg_per_h));
  form("rate_random_walk_deg_per_h_per_sqrt_h", not_negative(noise.rate_random_walk_deg_per_h_per_sqrt_h));
  form("start_deg_per_h", not_negative(noise.start_deg_per_h));
}

/// The noise of what a model leaves of each cluster, by the Allan deviation of the cluster means over whole records,
/// ramps and all: what tracking must follow is the gyro's own wander and what the model does not know, together. Give
/// it the held-out residual; one of the fit's own clusters lacks what the fit has taken up. N, B and K alone are fitted
/// (allan.hpp), and one that is not seen is 0: means over 100 s do not tell quantisation from N, and a ramp of the
/// record is no law for the time after it. Where no N is seen, since what the model does not know is larger, it is that
/// of the record's noise floor, the white noise of one mean (°/h; NaN: not known). The bias at the start is as
/// uncertain as the residual's RMS. Fails with usage if fewer than five averaging times can be had, or there is no N of
/// either.
[[nodiscard]] Result<BiasNoise> noise_of_residual(const Eigen::Ref<const Eigen::VectorXd>& residual_deg_per_h,
                                                  const data::Clusters& clusters, double floor_deg_per_h);

}  // namespace gyrotherm::tracking
