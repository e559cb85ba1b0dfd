// SPDX-License-Identifier: Apache-2.0
/// The χ² distribution, central and noncentral, by Boost.Math. Degrees of freedom are above 0 and need not be whole;
/// values and the noncentrality λ, the sum of the squares of the means, are not below 0.
#pragma once

namespace gyrotherm::data {

/// Returns the probability that χ² of `freedom` degrees exceeds `value`.
[[nodiscard]] double chi_squared_exceeds(double value, double freedom);

/// Returns the value that χ² exceeds with a probability between 0 and 1, down to 1e-300.
[[nodiscard]] double chi_squared_limit(double probability, double freedom);

/// Returns the probability that noncentral χ² exceeds `value`.
[[nodiscard]] double noncentral_chi_squared_exceeds(double value, double freedom, double noncentrality);

/// Returns the density of noncentral χ² at a value above 0.
[[nodiscard]] double noncentral_chi_squared_density(double value, double freedom, double noncentrality);

}  // namespace gyrotherm::data
