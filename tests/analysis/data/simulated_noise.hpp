/// The noises of a gyro, made to order.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace gyrotherm {

/// Coefficients as in allan_fit.hpp: Q in °, N in °/√h, B in °/h, K in °/h/√h, R in °/h².
struct SimulatedNoise {
  double Q{}, N{}, B{}, K{}, R{};
};

/// `samples` rates in °/h, each the mean over `interval_s`.
[[nodiscard]] Eigen::VectorXd simulate(const SimulatedNoise& noise, Eigen::Index samples, double interval_s,
                                       std::mt19937_64& random);

}  // namespace gyrotherm
