// SPDX-License-Identifier: Apache-2.0
/// Simulated biases with the noise of the default virtual gyro, and their exact statistics.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "analysis/tracking/state_space.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::tracking {

inline constexpr double kInterval_s = 100;
inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Returns N, B and K of profiles/rigs/virtual.toml, and the turn-on scatter of the residuals on that rig.
[[nodiscard]] inline BiasNoise virtual_noise() {
  return {.angle_random_walk_deg_per_sqrt_h = 3e-4,
          .instability_deg_per_h = 4e-4,
          .rate_random_walk_deg_per_h_per_sqrt_h = 3e-5,
          .start_deg_per_h = 2e-3};
}

[[nodiscard]] inline StateSpace virtual_space() { return state_space(virtual_noise(), kInterval_s); }

/// Draws independent standard normal numbers.
[[nodiscard]] inline Eigen::VectorXd white_noise(Eigen::Index count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(count, [&] { return normal(random); });
}

/// Simulates a bias with this noise and a random turn-on, and its measured means. Kasdin's filter generates the
/// flicker, so the simulation does not use the Markov processes under test.
[[nodiscard]] inline DrawnBias known_bias(Eigen::Index intervals, std::uint64_t seed,
                                          const BiasNoise& noise = virtual_noise()) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  DrawnBias known;
  const double turn_on = noise.start_deg_per_h * normal(random);
  known.bias_deg_per_h =
      data::simulate({.B = noise.instability_deg_per_h, .K = noise.rate_random_walk_deg_per_h_per_sqrt_h}, intervals,
                     kInterval_s, random)
          .array() +
      turn_on;
  known.measured_deg_per_h = known.bias_deg_per_h + data::simulate({.N = noise.angle_random_walk_deg_per_sqrt_h},
                                                                   intervals, kInterval_s, random);
  return known;
}

/// Computes the covariance matrix of the bias over all intervals.
[[nodiscard]] inline Eigen::MatrixXd covariance_of_bias(const StateSpace& space, Eigen::Index intervals) {
  return Eigen::MatrixXd::NullaryExpr(intervals, intervals, [&](Eigen::Index i, Eigen::Index j) {
    double sum = space.start(0) + space.fresh(0) * static_cast<double>(std::min(i, j));
    for (Eigen::Index m = 1; m < kStates; ++m) {
      sum += space.start(m) * std::pow(space.memory(m), static_cast<double>(std::abs(i - j)));
    }
    return sum;
  });
}

/// Mean and standard deviation of Σ_k weight_k bias_k given the available rates. They follow from the conditional
/// normal distribution with the dense covariance matrix.
struct Posterior {
  double mean{}, std{};
};
[[nodiscard]] inline Posterior posterior(const StateSpace& space, const Eigen::VectorXd& weights,
                                         const Eigen::VectorXd& rates) {
  std::vector<Eigen::Index> available;
  for (Eigen::Index k = 0; k < rates.size(); ++k) {
    if (std::isfinite(rates(k))) available.push_back(k);
  }
  const Eigen::MatrixXd prior = covariance_of_bias(space, weights.size());
  const Eigen::VectorXd reach = (prior * weights)(available);
  Eigen::MatrixXd measured = prior(available, available);
  measured.diagonal().array() += space.white;
  const Eigen::LDLT<Eigen::MatrixXd> solver(measured);
  const Eigen::VectorXd values = rates(available);
  return {reach.dot(solver.solve(values)), std::sqrt(weights.dot(prior * weights) - reach.dot(solver.solve(reach)))};
}

}  // namespace gyrotherm::tracking
