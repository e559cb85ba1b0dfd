/// Overlapping Allan deviation: how the noise of a rate depends on the time it is averaged over.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrotherm {

/// Rates in °/h, evenly spaced in time, cut where a sample is missing: no difference is taken across two stretches.
struct RateStretches {
  double interval_s{};
  std::vector<Eigen::VectorXd> values;  ///< finite
};

/// Cuts `rate_deg_per_h`, sample k taken at `time_s`(k), wherever a value is not finite or a time step differs from the
/// interval by half of it or more.
[[nodiscard]] RateStretches cut_at_gaps(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                                        const Eigen::Ref<const Eigen::VectorXd>& rate_deg_per_h, double interval_s);

/// One averaging time.
struct AllanPoint {
  int m{};         ///< samples averaged
  double tau_s{};  ///< m intervals
  double deviation_deg_per_h{};
  double error_deg_per_h{};  ///< its standard error, deviation/√(2(K − 1)), K non-overlapping means of m samples;
                             ///< of several stretches, the sum of their K − 1
  int differences{};         ///< overlapping differences averaged
};
using AllanCurve = std::vector<AllanPoint>;

/// Overlapping Allan deviation of evenly spaced values at averaging `m`; there are at least 2m of them.
/// θ_0 = 0, θ_i = θ_{i−1} + value_i: σ² = Σ_i (θ_{i+2m} − 2θ_{i+m} + θ_i)²/(2m²(n + 1 − 2m)) (NIST SP 1065, eq. 11).
[[nodiscard]] double overlapping_allan_deviation(const Eigen::Ref<const Eigen::VectorXd>& values, int m);

/// At m = 1, 2, 4, … as long as at least two independent differences are left; the squares of all stretches are
/// averaged together. Empty if no stretch is long enough.
[[nodiscard]] AllanCurve allan_curve(const RateStretches& rates);

}  // namespace gyrotherm
