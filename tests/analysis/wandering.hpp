/// Thermometers that tell nothing of each other, which no real block has: where only one answer can be right.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "analysis/data/clusters.hpp"

namespace gyrotherm {

/// The clusters with temperatures that wander independently about 20 °C with a STD of 10 °C, correlated over about ten
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

}  // namespace gyrotherm
