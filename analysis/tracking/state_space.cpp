// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/state_space.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/quantity.hpp"
#include "core/random.hpp"

namespace gyrotherm::tracking {
namespace {

/// Draws from the standard normal distribution (Box and Muller 1958).
double draw_normal(std::mt19937_64& random) {
  const double radius = std::sqrt(-2 * std::log(1 - uniform(random)));
  return radius * std::cos(2 * std::numbers::pi * uniform(random));
}

/// Returns the variance of means over Δ due to flicker noise that is faster than all Markov processes: (B²/π) ∫
/// sin²x/x³ dx from Δ/(2τ) on. τ is the lower end of the decade that the fastest process covers, and at least 0.9 Δ.
/// The integral equals ln(τ/Δ) + 3/2 − γ to within 6 %.
double fast_flicker_variance(double instability, double fastest_h, double interval_h) {
  constexpr double kHalfDecade = 3.1622776601683795;
  const double integral = std::log(fastest_h / kHalfDecade / interval_h) + 1.5 - std::numbers::egamma;
  return instability * instability / std::numbers::pi * integral;
}

State draw_state(const State& variances, std::mt19937_64& random) {
  return variances.unaryExpr([&](double variance) { return std::sqrt(variance) * draw_normal(random); });
}

}  // namespace

std::array<double, kMarkovProcesses> correlation_times_h(const BiasNoise& noise, double interval_s) {
  constexpr double kLeastIntervals = 30, kFlicker = 2 * std::numbers::ln2 / std::numbers::pi;
  const double ratio = noise.angle_random_walk_deg_per_sqrt_h / noise.instability_deg_per_h;
  const double least_h = kLeastIntervals * interval_s / kSecondsPerHour;
  const double middle_h = noise.instability_deg_per_h > 0 ? std::max(least_h, ratio * ratio / kFlicker) : least_h;
  return {middle_h / 10, middle_h, middle_h * 10};
}

StateSpace state_space(const BiasNoise& noise, double interval_s) {
  assert(interval_s > 0 && noise.angle_random_walk_deg_per_sqrt_h > 0);
  const auto square = [](double value) { return value * value; };
  const double interval_h = interval_s / kSecondsPerHour;
  const auto times_h = correlation_times_h(noise, interval_s);
  StateSpace space{.interval_s = interval_s};
  space.memory(0) = 1;
  space.fresh(0) = square(noise.rate_random_walk_deg_per_h_per_sqrt_h) * interval_h;
  space.start(0) = square(noise.start_deg_per_h);
  space.white = square(noise.angle_random_walk_deg_per_sqrt_h) / interval_h +
                fast_flicker_variance(noise.instability_deg_per_h, times_h.front(), interval_h);
  for (Eigen::Index i = 1; i < kStates; ++i) {
    space.memory(i) = std::exp(-interval_h / times_h[static_cast<std::size_t>(i - 1)]);
    space.start(i) = square(noise.instability_deg_per_h) * std::numbers::ln10 / std::numbers::pi;
    space.fresh(i) = space.start(i) * (1 - square(space.memory(i)));
  }
  return space;
}

DrawnBias draw(const StateSpace& space, Eigen::Index intervals, std::mt19937_64& random) {
  DrawnBias drawn_bias{Eigen::VectorXd(intervals), Eigen::VectorXd(intervals)};
  State state = draw_state(space.start, random);
  for (Eigen::Index k = 0; k < intervals; ++k) {
    if (k > 0) state = state.cwiseProduct(space.memory) + draw_state(space.fresh, random);
    drawn_bias.bias_deg_per_h(k) = state.sum();
    drawn_bias.measured_deg_per_h(k) = state.sum() + std::sqrt(space.white) * draw_normal(random);
  }
  return drawn_bias;
}

SteadyState steady_state(const StateSpace& space) {
  constexpr int kMostDoublings = 60;
  constexpr double kConverged = 1e-15;
  const Covariance identity = Covariance::Identity();
  // Iterates X = A'X(I + GX)⁻¹A + H in units of the white variance.
  Covariance a = space.memory.asDiagonal();
  Covariance g = Covariance::Ones();
  Covariance h = (space.fresh / space.white).asDiagonal();
  for (int k = 0; k < kMostDoublings; ++k) {
    const Covariance solved = (identity + g * h).partialPivLu().inverse();
    const Covariance more = a.transpose() * h * solved * a;
    g += (a * solved * g * a.transpose()).eval();
    a = (a * solved * a).eval();
    h += more;
    if (more.cwiseAbs().maxCoeff() <= kConverged * h.cwiseAbs().maxCoeff()) break;
  }
  const State row_sums = h.rowwise().sum();
  return {.gain = row_sums / (row_sums.sum() + 1), .predicted = h * space.white};
}

}  // namespace gyrotherm::tracking
