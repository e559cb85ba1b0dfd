/// The five noises of a gyro, read from its Allan deviation.
///
/// With τ in h and σ in °/h (IEEE notation): σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3 + R²τ²/2.
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
#pragma once

#include <array>

#include "analysis/data/allan.hpp"

namespace gyrotherm {

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
};

struct AllanFit {
  std::array<NoiseCoefficient, kNoiseTerms> coefficients;  ///< in the order of NoiseTerm
  double misfit{};                                         ///< of σ, relative; 0: sampling explains what is left
  double lowest_tau_s{};                                   ///< where the fitted σ is least among the curve's τ
};

/// The coefficient of a term.
[[nodiscard]] const NoiseCoefficient& of(const AllanFit& fit, NoiseTerm term);

/// σ of one term alone, and of all that are seen, °/h.
[[nodiscard]] double deviation_of(const NoiseCoefficient& coefficient, double tau_s);
[[nodiscard]] double deviation_of(const AllanFit& fit, double tau_s);

/// `curve` is allan_curve(rates) and not empty. A curve of fewer than five points is fitted with as many terms, taken
/// in the order N, Q, K, B, R.
[[nodiscard]] AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates);

}  // namespace gyrotherm
