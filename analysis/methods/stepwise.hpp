// SPDX-License-Identifier: Apache-2.0
/// Stepwise regression by partial F tests (Efroymson 1960); for ring laser gyros: Zhang and Long, Opt. Tech. 32 (2006)
/// 738, ref. 6 of the paper.
///
/// Starts empty; adds the input with the largest partial F = (RSS_old − RSS_new)/(RSS_new/(n − p − 1)), p inputs after
/// adding, if F > 3.84; then drops any with F < 2.71, the least first; stops when neither happens. 3.84 and 2.71 are
/// the 5 % and 10 % points of F with one and many degrees of freedom, if errors were independent, which clusters' are
/// not: inputs that mean nothing may enter.
#pragma once

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

inline constexpr double kFToEnter = 3.84;
inline constexpr double kFToRemove = 2.71;

/// Nothing is chosen on held-out folds: the F tests choose. An input of which less than 10⁻⁹ of its spread is its own,
/// given those already taken, is not asked. Inputs not taken keep the weight 0; the particulars name those taken. The
/// effective parameters are those taken and the constant; that they were picked is not counted. Fails with usage if
/// there are not three samples more than inputs that enter.
[[nodiscard]] Result<Fit> fit_stepwise(const FitInput& set, const HyperParameters& parameters,
                                       const MethodOptions& options);

}  // namespace gyrotherm::methods
