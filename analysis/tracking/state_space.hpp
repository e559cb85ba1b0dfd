// SPDX-License-Identifier: Apache-2.0
/// The bias as the sum of a few states, for a Kalman filter: a random walk, and Markov processes that together are
/// flicker noise. Sequences are means over equal intervals, one after the other, NaN where one is missing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <random>

#include "analysis/tracking/bias_noise.hpp"

namespace gyrotherm::tracking {

inline constexpr int kMarkovProcesses = 3;
inline constexpr int kStates = 1 + kMarkovProcesses;         ///< the walk, then the processes, the fastest first
using State = Eigen::Matrix<double, kStates, 1>;             ///< °/h each; the bias is their sum
using Covariance = Eigen::Matrix<double, kStates, kStates>;  ///< (°/h)²

/// x(k + 1) = memory ∘ x(k) + w, a mean over the interval is Σ x + v. No state acts on another.
struct StateSpace {
  double interval_s{};
  State memory = State::Zero();  ///< what an interval leaves of each state
  State fresh = State::Zero();   ///< variance of what it adds, of w
  State start = State::Zero();   ///< variance before the first mean
  double white{};                ///< variance of v
};

/// The states of a noise.
///
/// The random walk starts with the start's variance and adds K²Δ an interval; within one it is taken to stand still.
/// White is N²/Δ. Where a gyro counts its angle in steps, average until they no longer show in that before you track:
/// their errors in neighbouring intervals are not independent.
///
/// Bias instability B is flicker noise, S(f) = B²/(2πf) (IEEE Std 952-1997, annex C), which no finite number of states
/// has; a sum of first-order Markov processes comes as near as one likes (van der Ziel, Physica 16 (1950) 359), and one
/// a decade of correlation time is enough (Keshner, Proc. IEEE 70 (1982) 212). Of the variance B² ln 10/π each, their
/// spectrum ripples by 2/cosh(π²/ln 10) = 5.5 % about the flicker's. Three are enough for a filter if they stand at the
/// right times: τ, τ/10 and 10τ about that τ at which white noise and flicker have one Allan deviation, N²/τ =
/// (2 ln 2/π)B². What is faster is white to them and is counted there; what is slower, the walk and the start take up.
/// τ is at least 30 intervals. What their forecast of the next hour loses to that of thirteen processes over six
/// decades is below 1 % (a test computes it).
[[nodiscard]] StateSpace state_space(const BiasNoise& noise, double interval_s);

/// The correlation times of the processes, h.
[[nodiscard]] std::array<double, kMarkovProcesses> correlation_times_h(const BiasNoise& noise, double interval_s);

/// A bias and its measured means, as a state space makes them.
struct DrawnBias {
  Eigen::VectorXd bias_deg_per_h, measured_deg_per_h;
};
[[nodiscard]] DrawnBias draw(const StateSpace& space, Eigen::Index intervals, std::mt19937_64& random);

/// Where the filter settles when no mean is missing.
struct SteadyState {
  State gain = State::Zero();                 ///< of each state, per innovation
  Covariance predicted = Covariance::Zero();  ///< before each mean
};

/// Solves the discrete algebraic Riccati equation of the filter by structure-preserving doubling (Anderson, Int. J.
/// Control 28 (1978) 295; Chu, Fan, Lin, Wang, Int. J. Control 77 (2004) 767), which needs some ten steps where the
/// filter itself needs thousands. A walk that does not walk (K = 0) is known in the end: its gain is 0.
[[nodiscard]] SteadyState steady_state(const StateSpace& space);

}  // namespace gyrotherm::tracking
