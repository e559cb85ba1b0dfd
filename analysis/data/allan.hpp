// SPDX-License-Identifier: Apache-2.0
/// Overlapping Allan deviation, how the noise of a rate depends on the time it is averaged over, and the five noises of
/// a gyro that are read from it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/form.hpp"

namespace gyrotherm::data {

/// Rates in °/h, evenly spaced in time, cut where a sample is missing: no difference is taken across two stretches.
struct RateStretches {
  double interval_s{};
  std::vector<Eigen::VectorXd> values;  ///< finite
};

/// Cuts `rate_deg_per_h`, sample k taken at `time_s`(k), wherever a value is not finite or a time step differs from the
/// interval by half of it or more.
[[nodiscard]] RateStretches cut_at_gaps(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                                        const Eigen::Ref<const Eigen::VectorXd>& rate_deg_per_h, double interval_s);

/// The overlapping Allan deviation at one averaging time.
struct AllanPoint {
  int m{};         ///< samples averaged
  double tau_s{};  ///< m intervals
  double deviation_deg_per_h{};
  double error_deg_per_h{};  ///< its standard error, deviation/√(2(K − 1)), K non-overlapping means of m samples;
                             ///< of several stretches, the sum of their K − 1
  int differences{};         ///< overlapping differences averaged
};
using AllanCurve = std::vector<AllanPoint>;

void describe(auto& form, Like<AllanPoint> auto& point) {
  form("tau_s", point.tau_s);
  form("deviation_deg_per_h", point.deviation_deg_per_h);
  form("error_deg_per_h", point.error_deg_per_h);
  form("differences", point.differences);
}

/// The overlapping Allan deviation at averaging `m`, which is at least 1; a stretch has at least 2m values. With θ_0 =
/// 0 and θ_i = θ_{i−1} + value_i it is σ² = Σ_i (θ_{i+2m} − 2θ_{i+m} + θ_i)²/(2m²(n + 1 − 2m)) (NIST SP 1065, eq. 11);
/// the squares of all stretches are averaged together.
[[nodiscard]] AllanPoint allan_point(const RateStretches& rates, int m);

/// The points at m = 1, 2, 4, … as long as at least two independent differences are left; empty if no stretch is long
/// enough.
[[nodiscard]] AllanCurve allan_curve(const RateStretches& rates);

/// The squares of Q (in °), N, B, K and R, with τ in h and σ in °/h.
using NoiseSquares = Eigen::Vector<double, 5>;

/// What each square is multiplied by in σ²(τ): 3/τ², 1/τ, 2 ln 2/π, τ/3, τ²/2.
[[nodiscard]] NoiseSquares noise_shapes(double tau_h);

/// How the points of a curve vary together: the covariance of its Allan variances, in (°/h)⁴, for Gaussian noise of
/// these squares over stretches as long as those of `rates`.
///
/// The angle θ has the generalised covariance g(t) = Q²δ(t) − N²|t|/2 + B²t² ln|t|/(2π) + K²|t|³/12: that of its second
/// differences over m and m' samples, a lag l apart, is c(l) = Σ w_a w_b g(l + a·m − b·m'), w = (1, −2, 1); the drift R
/// adds the mean μ_m = R(mτ_0)². The mean squares of two such differences have the covariance
/// Σ over all pairs of (2c² + 4μ_m μ_m' c), divided by the numbers of both.
[[nodiscard]] Eigen::MatrixXd allan_covariance(const AllanCurve& curve, const RateStretches& rates,
                                               const NoiseSquares& squares);

enum class NoiseTerm { quantisation, angle_random_walk, bias_instability, rate_random_walk, rate_ramp };
inline constexpr std::size_t kNoiseTerms = 5;

/// How a coefficient is written, and where its line is read.
struct NoiseTermInfo {
  const char* symbol;   ///< "N"
  const char* name;     ///< "angle random walk"
  const char* unit;     ///< "°/√h"
  const char* formula;  ///< of its share of σ, τ in h: "N/√τ"
  double read_off_s;    ///< where σ of this term alone is the coefficient; NaN for B: anywhere, divided by 0.664
};
[[nodiscard]] const NoiseTermInfo& info(NoiseTerm term);

struct NoiseCoefficient {
  NoiseTerm term{};
  bool seen{};       ///< its square is at least twice its standard error
  double value{};    ///< in the unit of its term (Q in arcsec); 0 if not seen
  double error{};    ///< standard error; 0 if not seen
  double at_most{};  ///< upper limit of 95 %, the terms that are seen held to their form
  /// The square of the coefficient, in its unit squared, and its standard error, whether it is seen or not: of a term
  /// that is not seen, as it is fitted beside those that are. Not negative; NaN where the curve has too few points.
  double square{}, square_error{};
};

/// The coefficients in the order of NoiseTerm when nothing is seen, nor a limit known.
[[nodiscard]] std::array<NoiseCoefficient, kNoiseTerms> nothing_seen();

struct AllanFit {
  std::array<NoiseCoefficient, kNoiseTerms> coefficients = nothing_seen();  ///< in the order of NoiseTerm
  double misfit{};        ///< of σ, relative; 0: sampling explains what is left
  double lowest_tau_s{};  ///< where the fitted σ is least among the curve's τ
};

/// The form of the coefficients, each under its symbol.
void describe(auto& form, Like<AllanFit> auto& fit) {
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    auto& coefficient = fit.coefficients[k];
    const NoiseTermInfo& about = info(static_cast<NoiseTerm>(k));
    form.object(about.symbol, [&](auto& form_of_one) {
      form_of_one.derived("name", about.name);
      form_of_one.derived("unit", about.unit);
      form_of_one.derived("formula", about.formula);
      form_of_one.derived("read_off_s", about.read_off_s);
      form_of_one("seen", coefficient.seen);
      form_of_one("value", known(coefficient.value));
      form_of_one("error", known(coefficient.error));
      form_of_one("at_most", coefficient.at_most);
    });
  }
}

/// The coefficient of a term.
[[nodiscard]] const NoiseCoefficient& of(const AllanFit& fit, NoiseTerm term);

/// The coefficient by its square alone, seen or not: what an uncertainty budget takes. A term that chance made small is
/// then small, and no term is dropped. 0 where the square is not known.
[[nodiscard]] NoiseCoefficient estimate_of(const NoiseCoefficient& coefficient);

/// The σ that one term alone makes at `tau_s`, °/h.
[[nodiscard]] double deviation_of(const NoiseCoefficient& coefficient, double tau_s);
/// The σ that all terms that are seen make together, °/h.
[[nodiscard]] double deviation_of(const AllanFit& fit, double tau_s);

/// Reads the five noises from `curve`, which is allan_curve(rates) and not empty. With τ in h and σ in °/h (IEEE
/// notation): σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3 + R²τ²/2. A curve of fewer than five points is fitted with
/// as many terms, taken in the order N, Q, K, B, R.
///
/// The squares of the coefficients are fitted to σ² by weighted least squares, none negative; the weights are those of
/// the relative error of σ, at first 1/√(2(K − 1)), about the fitted curve, since weights about the measured one favour
/// the points that chance made low. A term stays only if its square is twice its standard error. Reading lines of slope
/// −½, 0, +½ off the curve instead needs a stretch where one noise is alone: a hold of an hour has it for N at best,
/// and the line credits the neighbours' share to the one that is read.
///
/// Standard errors are exact for Gaussian noise of the fitted kind: the points of an overlapping curve share their
/// samples, so each pair's covariance is computed, and errors that took them for independent would be too small.
/// Where the curve departs from the five terms by more than chance allows, χ² > f + 3√(2f) (pulses that beat with the
/// sampling, a drift that is no straight line), a relative misfit common to all points is added to their errors until
/// χ² is its f degrees of freedom (Mandel and Paule 1970), so that the sure points of short τ do not bend all the rest.
[[nodiscard]] AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates);

/// The same with no other terms than these, which are not more than the points: where the curve cannot tell all five
/// apart, as means over minutes cannot tell quantisation from angle random walk.
[[nodiscard]] AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates, const std::vector<NoiseTerm>& of);

}  // namespace gyrotherm::data
