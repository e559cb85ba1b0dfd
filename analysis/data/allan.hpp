// SPDX-License-Identifier: Apache-2.0
/// Overlapping Allan deviation of a rate, and the five noise coefficients of a gyro that are fitted to it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/form.hpp"

namespace gyrotherm::data {

/// Evenly spaced rates in °/h, cut into stretches at missing samples. No difference spans two stretches.
struct RateStretches {
  double interval_s{};
  /// Finite values of each stretch.
  std::vector<Eigen::VectorXd> values;
};

/// Cuts `rate_deg_per_h` into stretches; sample k was taken at `time_s`(k). A stretch ends at each value that is not
/// finite, and at each time step that differs from `interval_s` by half the interval or more.
[[nodiscard]] RateStretches cut_at_gaps(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                                        const Eigen::Ref<const Eigen::VectorXd>& rate_deg_per_h, double interval_s);

/// Overlapping Allan deviation at one averaging time.
struct AllanPoint {
  /// Number of samples averaged.
  int m{};
  double tau_s{};  ///< m intervals
  double deviation_deg_per_h{};
  /// Standard error deviation/√(2(K − 1)), where K is the number of non-overlapping means of m samples. For several
  /// stretches, K − 1 is summed over the stretches.
  double error_deg_per_h{};
  /// Number of overlapping differences averaged.
  int differences{};
};
using AllanCurve = std::vector<AllanPoint>;

void describe(auto& form, Like<AllanPoint> auto& point) {
  form("tau_s", point.tau_s);
  form("deviation_deg_per_h", point.deviation_deg_per_h);
  form("error_deg_per_h", point.error_deg_per_h);
  form("differences", point.differences);
}

/// Computes the overlapping Allan deviation at averaging factor `m` ≥ 1. At least one stretch has 2m values or more.
/// Let θ_0 = 0 and θ_i = θ_{i−1} + value_i. Then σ² = Σ_i (θ_{i+2m} − 2θ_{i+m} + θ_i)²/(2m²(n + 1 − 2m)) (NIST SP 1065,
/// eq. 11). The squared differences of all stretches are averaged together.
[[nodiscard]] AllanPoint allan_point(const RateStretches& rates, int m);

/// Computes the points at m = 1, 2, 4, … while at least two independent differences remain. Returns an empty curve if
/// no stretch is long enough.
[[nodiscard]] AllanCurve allan_curve(const RateStretches& rates);

/// Squares of Q (in °), N, B, K and R, for τ in h and σ in °/h.
using NoiseSquares = Eigen::Vector<double, 5>;

/// Returns the factor of each square in σ²(τ): 3/τ², 1/τ, 2 ln 2/π, τ/3, τ²/2.
[[nodiscard]] NoiseSquares noise_shapes(double tau_h);

/// Computes the covariance of the Allan variances of a curve, in (°/h)⁴, for Gaussian noise with the given squared
/// coefficients in stretches as long as those of `rates`.
///
/// The angle θ has the generalised covariance g(t) = Q²δ(t) − N²|t|/2 + B²t² ln|t|/(2π) + K²|t|³/12. Two second
/// differences of θ over m and m' samples at lag l have the covariance c(l) = Σ w_a w_b g(l + a·m − b·m'), w = (1, −2,
/// 1). The drift R adds the mean μ_m = R(mτ_0)². The mean squares of two such differences have the covariance Σ (2c² +
/// 4μ_m μ_m' c), summed over all pairs and divided by both numbers of differences.
[[nodiscard]] Eigen::MatrixXd allan_covariance(const AllanCurve& curve, const RateStretches& rates,
                                               const NoiseSquares& squares);

enum class NoiseTerm { quantisation, angle_random_walk, bias_instability, rate_random_walk, rate_ramp };
inline constexpr std::size_t kNoiseTerms = 5;

/// Notation of a coefficient, and the averaging time at which it is read off.
struct NoiseTermInfo {
  const char* symbol;  ///< "N"
  const char* name;    ///< "angle random walk"
  const char* unit;    ///< "°/√h"
  /// Contribution of the term to σ, with τ in h: "N/√τ".
  const char* formula;
  /// Averaging time at which the σ of this term equals the coefficient. NaN for B, whose σ is 0.664·B at every τ.
  double read_off_s;
};
[[nodiscard]] const NoiseTermInfo& info(NoiseTerm term);

struct NoiseCoefficient {
  NoiseTerm term{};
  /// Set if the term is significant: the square is at least twice its standard error.
  bool seen{};
  /// Value in the unit of the term (Q in arcsec) and its standard error. Both are 0 if the term is not significant.
  double value{};
  double error{};
  /// Upper 95 % limit, for an unchanged set of significant terms.
  double at_most{};
  /// Square of the coefficient, in its unit squared, and the standard error of the square. Both are at least 0. A term
  /// that is not significant has them too, from a fit together with the significant terms. NaN if the curve has too few
  /// points.
  double square{}, square_error{};
};

/// Returns coefficients in the order of NoiseTerm. None is significant or has an upper limit.
[[nodiscard]] std::array<NoiseCoefficient, kNoiseTerms> no_significant_terms();

struct AllanFit {
  /// Coefficients in the order of NoiseTerm.
  std::array<NoiseCoefficient, kNoiseTerms> coefficients = no_significant_terms();
  /// Relative misfit of σ. 0 if sampling errors explain the residuals of the fit.
  double misfit{};
  /// Averaging time of the curve at which the fitted σ is lowest.
  double lowest_tau_s{};
};

/// Describes the coefficients, each under its symbol.
void describe(auto& form, Like<AllanFit> auto& fit) {
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    auto& coefficient = fit.coefficients[k];
    const NoiseTermInfo& about = info(static_cast<NoiseTerm>(k));
    form.object(about.symbol, [&](auto& inner) {
      inner.derived("name", about.name);
      inner.derived("unit", about.unit);
      inner.derived("formula", about.formula);
      inner.derived("read_off_s", about.read_off_s);
      inner("seen", coefficient.seen);
      inner("value", known(coefficient.value));
      inner("error", known(coefficient.error));
      inner("at_most", coefficient.at_most);
    });
  }
}

/// Returns the coefficient of a term.
[[nodiscard]] const NoiseCoefficient& find_coefficient(const AllanFit& fit, NoiseTerm term);

/// Computes the coefficient from its square, whether the term is significant or not. An uncertainty budget uses it for
/// all terms: none is dropped, and a small term contributes little. The value is 0 if the square is unknown.
[[nodiscard]] NoiseCoefficient estimate_from_square(const NoiseCoefficient& coefficient);

/// Computes σ of a single term at `tau_s`, in °/h.
[[nodiscard]] double noise_deviation(const NoiseCoefficient& coefficient, double tau_s);
/// Computes the combined σ of all significant terms at `tau_s`, in °/h.
[[nodiscard]] double noise_deviation(const AllanFit& fit, double tau_s);

/// Fits the five noise coefficients to `curve`, which must be allan_curve(rates) and not empty. With τ in h and σ in
/// °/h (IEEE notation): σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3 + R²τ²/2. A curve with fewer than five points is
/// fitted with one term per point, taken in the order N, Q, K, B, R.
///
/// The squared coefficients are fitted to σ² by weighted least squares under the constraint that none is negative. The
/// weights follow from the relative error of σ, initially 1/√(2(K − 1)), and the fitted σ: weights from the measured σ
/// would favour points that are low by chance. A term is kept only if its square is at least twice its standard error.
/// Reading lines of slope −½, 0 and +½ off the curve would need a range of τ where one noise dominates. A hold of one
/// hour has such a range for N at best, and the line then includes the contribution of the neighbouring noises.
///
/// Standard errors are exact for Gaussian noise of the fitted kind. The points of an overlapping curve share samples,
/// so the covariance of each pair is computed; assuming independent points would give errors that are too small. If the
/// curve departs from the five terms by more than chance allows, χ² > f + 3√(2f), a common relative misfit is added to
/// the errors of all points until χ² equals its f degrees of freedom (Mandel and Paule 1970). Such departures are
/// caused by a beat between pulses and samples and by a drift that is not linear in time. The misfit keeps the precise
/// points at short τ from distorting the fit at long τ.
[[nodiscard]] AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates);

/// Fits only the given terms, at most one per point. Use this if the curve cannot separate all five terms: means over
/// minutes cannot separate quantisation from angle random walk.
[[nodiscard]] AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates, const std::vector<NoiseTerm>& of);

}  // namespace gyrotherm::data
