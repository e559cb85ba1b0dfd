// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/bias_noise.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "analysis/data/allan.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::tracking {
namespace {

/// Returns the root mean square of the finite values.
double finite_rms(const Eigen::Ref<const Eigen::VectorXd>& values) {
  double sum = 0;
  int count = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value * value;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace

Result<BiasNoise> estimate_bias_noise(const Eigen::Ref<const Eigen::VectorXd>& residual_deg_per_h,
                                      const data::Clusters& clusters, double floor_deg_per_h) {
  assert(residual_deg_per_h.size() == clusters.start_s.size());
  const auto rates = data::cut_at_gaps(clusters.start_s, residual_deg_per_h, clusters.length_s);
  const data::AllanCurve curve = data::allan_curve(rates);
  constexpr std::size_t kLeastTimes = 5;
  if (curve.size() < kLeastTimes) {
    return failure(FaultKind::usage, "bias tracking",
                   fmt::format("{} means are too few or have too many gaps to separate white noise from drift",
                               residual_deg_per_h.size()));
  }
  using enum data::NoiseTerm;
  const data::AllanFit fit = data::fit_allan(curve, rates, {angle_random_walk, bias_instability, rate_random_walk});
  const double floor_walk = floor_deg_per_h * std::sqrt(clusters.length_s / kSecondsPerHour);
  const double walk =
      find_coefficient(fit, angle_random_walk).seen ? find_coefficient(fit, angle_random_walk).value : floor_walk;
  if (!(walk > 0)) {
    return failure(FaultKind::usage, "bias tracking",
                   "the residual shows no angle random walk, and the record has no noise floor");
  }
  return BiasNoise{.angle_random_walk_deg_per_sqrt_h = walk,
                   .instability_deg_per_h = find_coefficient(fit, bias_instability).value,
                   .rate_random_walk_deg_per_h_per_sqrt_h = find_coefficient(fit, rate_random_walk).value,
                   .start_deg_per_h = finite_rms(residual_deg_per_h)};
}

}  // namespace gyrotherm::tracking
