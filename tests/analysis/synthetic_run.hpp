// SPDX-License-Identifier: Apache-2.0
/// Synthetic data for tests of the analysis. Results on them say nothing about real gyros.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"

namespace gyrotherm::data {

/// Parameters of a synthetic run: eight thermometers on a thermal network, a bias caused by gradients, and a program of
/// a few hundred clusters.
struct SyntheticRun {
  std::string run_id = "synthetic-1";
  /// Ramp rate of each cycle 20 → −20 → 50 → 20 °C.
  std::vector<double> cycle_rates_c_per_min = {2, 3, 4, 5};
  double hold_s = 1500;
  double noise_deg_per_h = 0.02;  ///< white, per second
  /// Part of the bias that depends on absolute temperature, not on gradients.
  double absolute_deg_per_h_per_c = 0;
  std::uint64_t seed = 1;
};

[[nodiscard]] Dataset make_synthetic_run(const SyntheticRun& run);

/// Returns the clusters with independent temperatures, for tests that need a unique result. On a real block,
/// temperatures are never independent. Each wanders about 20 °C with an STD of 10 °C and is correlated over about ten
/// clusters.
[[nodiscard]] inline Clusters wandering(Clusters clusters, std::uint64_t seed) {
  constexpr double kMemory = 0.9, kStd = 10, kCentre = 20;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (Eigen::Index j = 0; j < clusters.temperature_c.cols(); ++j) {
    double deviation = kStd * normal(random);
    for (Eigen::Index k = 0; k < clusters.temperature_c.rows(); ++k) {
      clusters.temperature_c(k, j) = kCentre + deviation;
      deviation = kMemory * deviation + std::sqrt(1 - kMemory * kMemory) * kStd * normal(random);
    }
  }
  return clusters;
}

/// Noise coefficients of a simulated gyro as in allan.hpp: Q in °, N in °/√h, B in °/h, K in °/h/√h, R in °/h².
struct SimulatedNoise {
  double Q{}, N{}, B{}, K{}, R{};
};

/// Simulates `samples` rates in °/h. Each is the mean over `interval_s`.
[[nodiscard]] Eigen::VectorXd simulate(const SimulatedNoise& noise, Eigen::Index samples, double interval_s,
                                       std::mt19937_64& random);

}  // namespace gyrotherm::data
