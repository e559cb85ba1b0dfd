// SPDX-License-Identifier: Apache-2.0
/// Distributions for statistics, computed by Boost.Math: χ², central and noncentral, Student's t and the binomial
/// distribution. Degrees of freedom are above 0 and need not be whole numbers.
#pragma once

#include <utility>

namespace gyrotherm::data {

// χ². Values and the noncentrality λ, the sum of the squared means, are not negative.

/// Returns the probability that χ² of `freedom` degrees exceeds `value`.
[[nodiscard]] double chi_squared_exceeds(double value, double freedom);

/// Returns the value that χ² exceeds with the given `probability`, from 1e-300 to below 1.
[[nodiscard]] double chi_squared_limit(double probability, double freedom);

/// Returns the probability that noncentral χ² exceeds `value`.
[[nodiscard]] double noncentral_chi_squared_exceeds(double value, double freedom, double noncentrality);

/// Returns the density of noncentral χ² at a value above 0.
[[nodiscard]] double noncentral_chi_squared_density(double value, double freedom, double noncentrality);

// Student's t. Infinite degrees of freedom give the normal distribution.

/// Returns P(T ≤ t).
[[nodiscard]] double students_t_probability(double t, double degrees_of_freedom);

/// Returns the coverage factor k of a two-sided interval, P(|T| ≤ k) = `share`, with 0 < `share` < 1: 1.960 for 95 %
/// and infinite degrees of freedom, 12.71 for one. The expanded uncertainty is k times a standard uncertainty with
/// these degrees of freedom (GUM, G.3).
[[nodiscard]] double coverage_factor(double share, double degrees_of_freedom);

// Binomial distribution.

/// Returns the probability of at most `successes` in `trials`, each with the given `probability`, 0 < p < 1. Neither
/// number need be whole: the distribution is continued by the incomplete beta function. 0 ≤ successes ≤ trials.
[[nodiscard]] double binomial_at_most(double successes, double trials, double probability);

/// Returns the exact interval of the probability of a success after `successes` in `trials`, for a coverage of `share`
/// (C. J. Clopper and E. S. Pearson, Biometrika 26, 404 (1934)). A probability p above it has
/// binomial_at_most(successes, trials, p) < (1 − share)/2. 0 ≤ successes ≤ trials, and trials > 0.
[[nodiscard]] std::pair<double, double> binomial_interval(double successes, double trials, double share);

}  // namespace gyrotherm::data
