// SPDX-License-Identifier: Apache-2.0
/// State space of the bias for a Kalman filter: the bias is the sum of a random walk and of Markov processes that
/// approximate flicker noise. Sequences are means over consecutive equal intervals, NaN where one is missing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <random>

#include "analysis/tracking/bias_noise.hpp"

namespace gyrotherm::tracking {

inline constexpr int kMarkovProcesses = 3;
/// The random walk, then the processes, the fastest first.
inline constexpr int kStates = 1 + kMarkovProcesses;
using State = Eigen::Matrix<double, kStates, 1>;             ///< °/h; the bias is their sum
using Covariance = Eigen::Matrix<double, kStates, kStates>;  ///< (°/h)²

/// Model x(k + 1) = memory ∘ x(k) + w; a mean over the interval is Σ x + v. States are independent.
struct StateSpace {
  double interval_s{};
  /// Factor of each state per interval.
  State memory = State::Zero();
  /// Variance of w.
  State fresh = State::Zero();
  /// Variance of each state before the first mean is processed.
  State start = State::Zero();
  double white{};  ///< variance of v
};

/// Computes the state space of a noise model.
///
/// The random walk starts with the initial variance and gains K²Δ per interval; it is taken as constant within an
/// interval. The white variance is N²/Δ. If a gyro counts its angle in pulses, choose intervals so long that
/// quantisation is negligible, because quantisation errors of neighbouring intervals are correlated and the model does
/// not include them.
///
/// Bias instability B is flicker noise, S(f) = B²/(2πf) (IEEE Std 952-1997, annex C), which has no exact model with
/// finitely many states. A sum of first-order Markov processes approximates it arbitrarily well (van der Ziel, Physica
/// 16 (1950) 359), and one process per decade of correlation time is sufficient (Keshner, Proc. IEEE 70 (1982) 212).
/// With a variance of B² ln 10/π each, their spectrum ripples by 2/cosh(π²/ln 10) = 5.5 % about that of flicker noise.
///
/// Three processes with suitable correlation times, τ/10, τ and 10τ, are sufficient for a filter. At τ white noise and
/// flicker have the same Allan deviation, N²/τ = (2 ln 2/π)B². Faster flicker is white for these processes and is added
/// to the white variance; slower flicker is absorbed by the random walk and the initial variance. τ is at least 30
/// intervals. Compared with thirteen processes over six decades, the forecast of the next hour is worse by less than 1
/// % (verified by a test).
[[nodiscard]] StateSpace state_space(const BiasNoise& noise, double interval_s);

/// Returns the correlation times of the processes, h.
[[nodiscard]] std::array<double, kMarkovProcesses> correlation_times_h(const BiasNoise& noise, double interval_s);

/// Simulated bias and its measured means.
struct DrawnBias {
  Eigen::VectorXd bias_deg_per_h, measured_deg_per_h;
};
[[nodiscard]] DrawnBias draw(const StateSpace& space, Eigen::Index intervals, std::mt19937_64& random);

/// Steady state of the filter without missing means.
struct SteadyState {
  State gain = State::Zero();                 ///< per innovation
  Covariance predicted = Covariance::Zero();  ///< before each mean
};

/// Solves the discrete algebraic Riccati equation of the filter by structure-preserving doubling (Anderson, Int. J.
/// Control 28 (1978) 295; Chu, Fan, Lin, Wang, Int. J. Control 77 (2004) 767). This takes about ten steps; iterating
/// the filter takes thousands. Without random walk (K = 0) the variance of the random-walk state converges to 0, and
/// its gain is 0.
[[nodiscard]] SteadyState steady_state(const StateSpace& space);

}  // namespace gyrotherm::tracking
