// SPDX-License-Identifier: Apache-2.0
/// Student's t: how many standard uncertainties an interval must reach to hold a stated share, when the standard
/// uncertainty itself is known with so many degrees of freedom (GUM, G.3).
#pragma once

namespace gyrotherm::data {

/// P(T ≤ t) of Student's distribution with `degrees_of_freedom` > 0, which need not be whole and may be infinite (the
/// normal distribution). With x = ν/(ν + t²) it is 1 − I_x(ν/2, ½)/2 for t ≥ 0, I the regularised incomplete beta
/// function (Abramowitz and Stegun 26.7.1), by its continued fraction (26.5.8); beyond a million degrees of freedom the
/// normal distribution of t(1 − 1/(4ν))/√(1 + t²/(2ν)) (26.7.8). It is right to about 1e-12.
[[nodiscard]] double students_t_probability(double t, double degrees_of_freedom);

/// The coverage factor of a two-sided interval: P(|T| ≤ t) = `share`, which is above 0 and below 1. It is 1.960 for
/// 95 % and infinite degrees of freedom, 12.71 for one.
[[nodiscard]] double coverage_factor(double share, double degrees_of_freedom);

}  // namespace gyrotherm::data
