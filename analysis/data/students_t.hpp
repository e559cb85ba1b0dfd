// SPDX-License-Identifier: Apache-2.0
/// Student's t distribution, by Boost.Math: the coverage factor of an uncertainty that is itself known with a number of
/// degrees of freedom (GUM, G.3).
#pragma once

namespace gyrotherm::data {

/// Returns P(T ≤ t). `degrees_of_freedom` is above 0, need not be whole, and may be infinite (the normal distribution).
[[nodiscard]] double students_t_probability(double t, double degrees_of_freedom);

/// Returns the coverage factor k of a two-sided interval, P(|T| ≤ k) = `share`, which is above 0 and below 1: 1.960 for
/// 95 % and infinite degrees of freedom, 12.71 for one.
[[nodiscard]] double coverage_factor(double share, double degrees_of_freedom);

}  // namespace gyrotherm::data
