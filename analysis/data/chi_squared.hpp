// SPDX-License-Identifier: Apache-2.0
/// χ², central and not: how likely a sum of squares of normal values is to be so large, with and without a shift of
/// their means, and how large it must be to be that unlikely. Degrees of freedom are above 0 and need not be whole,
/// values are 0 or more, and so is the noncentrality λ, the sum of the squares of the means.
#pragma once

namespace gyrotherm::data {

/// The probability that χ² of `freedom` degrees exceeds `value`: Γ(freedom/2, value/2)/Γ(freedom/2), by its series or
/// its continued fraction (Abramowitz and Stegun, 1964, 6.5.29 and 6.5.31).
[[nodiscard]] double chi_squared_exceeds(double value, double freedom);

/// The value that χ² exceeds with a probability between 0 and 1, by halving: a probability as small as 1e-300 has one.
[[nodiscard]] double chi_squared_limit(double probability, double freedom);

/// The probability that noncentral χ² exceeds `value`: that of the central one of freedom + 2j degrees, j drawn from
/// Poisson's distribution of mean λ/2 (Abramowitz and Stegun 26.4.25).
[[nodiscard]] double noncentral_chi_squared_exceeds(double value, double freedom, double noncentrality);

/// The density of noncentral χ² at a value above 0, by the same mixture.
[[nodiscard]] double noncentral_chi_squared_density(double value, double freedom, double noncentrality);

}  // namespace gyrotherm::data
