// SPDX-License-Identifier: Apache-2.0
/// How long a cumulative sum of vectors runs until chance makes it alarm.
#pragma once

namespace gyrotherm::fusion {

/// The average run length, in steps, of Crosier's multivariate cumulative sum (change_detector.hpp) of vectors that are
/// N(0, I), from 0 to its first alarm: with dimension p, slack k and limit h, all above 0.
///
/// The direction of the sum is uniform and tells nothing, so its length r is a Markov chain (Crosier, Technometrics 30
/// (1988) 291): before the slack is taken its square is noncentral χ²_p with λ = r². From r the run length is L(r) = 1
/// + P(0 | r) L(0) + ∫₀ʰ f(x | r) L(x) dx, Page's integral equation (Biometrika 41 (1954) 100), which is solved at the
/// nodes of Gauss and Legendre (Nyström's method). P(0 | r) is taken as what alarms and the nodes' own sum leave, so
/// that the probability of an alarm, on which all depends, is exact at each node. Three nodes a step and 24 more are
/// enough for some eight digits of a run of a million steps.
[[nodiscard]] double average_run_length(int dimension, double slack, double limit);

/// The limit with this average run length, which is above 1 and at most 1e9, to 1e-7 of it, by false position in the
/// Illinois form (Dowell and Jarratt, BIT 11 (1971) 168) on the logarithm of the run length, which is nearly straight.
/// It is nearly 0 where the slack alone makes runs that long.
[[nodiscard]] double limit_for_run_length(int dimension, double slack, double run_length);

}  // namespace gyrotherm::fusion
