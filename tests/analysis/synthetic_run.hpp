// SPDX-License-Identifier: Apache-2.0
/// Designed data for the tests of this room. They test code; they confirm nothing about gyros.
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

/// A small world: eight thermometers on a thermal network, a bias that gradients explain, and a program of a few
/// hundred clusters.
struct SyntheticRun {
  std::string run_id = "synthetic-1";
  std::vector<double> cycle_rates_c_per_min = {2, 3, 4, 5};  ///< one cycle each: 20 → −20 → 50 → 20 °C
  double hold_s = 1500;
  double noise_deg_per_h = 0.02;        ///< of one second, white
  double absolute_deg_per_h_per_c = 0;  ///< a part of the bias that no gradient sees
  std::uint64_t seed = 1;
};

[[nodiscard]] Dataset make_synthetic_run(const SyntheticRun& run);

/// The clusters with thermometers that tell nothing of each other, which no real block has: where only one answer can
/// be right. Their temperatures wander independently about 20 °C with a STD of 10 °C, correlated over about ten
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

/// The noises of a gyro, made to order; coefficients as in allan.hpp: Q in °, N in °/√h, B in °/h, K in °/h/√h, R in
/// °/h².
struct SimulatedNoise {
  double Q{}, N{}, B{}, K{}, R{};
};

/// Makes `samples` rates in °/h, each the mean over `interval_s`.
[[nodiscard]] Eigen::VectorXd simulate(const SimulatedNoise& noise, Eigen::Index samples, double interval_s,
                                       std::mt19937_64& random);

}  // namespace gyrotherm::data
