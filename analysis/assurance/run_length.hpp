// SPDX-License-Identifier: Apache-2.0
/// Run lengths of control charts for independent standard normal values, and the limits that give a stated false-alarm
/// rate. The false-alarm rate of a chart is the reciprocal of its average run length in control.
#pragma once

namespace gyrotherm::assurance {

/// Returns the average number of values until an individuals chart with limits ±`limit` signals. Each value has a mean
/// of `shift` standard deviations.
[[nodiscard]] double individuals_run_length(double limit, double shift = 0);

/// Returns the average number of values until an EWMA chart z ← λ x + (1 − λ) z, from z = 0, leaves ±L √(λ/(2 − λ)).
/// Markov chain of 201 states between the limits (Brook and Evans, Biometrika 59 (1972) 539; Lucas and Saccucci,
/// Technometrics 32 (1990) 1). Requires 0 < λ ≤ 1.
[[nodiscard]] double ewma_run_length(double lambda, double limit, double shift = 0);

/// Return the limit at which a chart has this false-alarm rate per value, 1e-8 ≤ `rate` < 0.5.
[[nodiscard]] double individuals_limit(double rate);
[[nodiscard]] double ewma_limit(double lambda, double rate);

}  // namespace gyrotherm::assurance
