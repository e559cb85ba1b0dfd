#include "simulator/lumped_gyro.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

namespace gyrotherm {
namespace {

enum Place : std::size_t { A, B, C, D, E };

double gradient_part(const LumpedBias& bias, BlockTemperatures t) {
  double sum = 0;
  for (std::size_t x = 1; x < kBlockPlaces; ++x) sum += bias.gradient_deg_per_h_per_k[x - 1] * (t[A] - t[x]);
  return sum;
}

}  // namespace

double block_mean_c(BlockTemperatures block_c) {
  return std::accumulate(block_c.begin(), block_c.end(), 0.0) / kBlockPlaces;
}

DegreesPerHour reference_bias(const LumpedBias& bias, BlockTemperatures t) {
  const double x = block_mean_c(t) - 20;
  const double absolute = bias.linear_deg_per_h_per_k * x + bias.quadratic_deg_per_h_per_k2 * x * x;
  const double wave = bias.wave_deg_per_h * std::sin(2 * std::numbers::pi * x / bias.wave_period_k);
  const double arms_k = (t[B] + t[D] - t[C] - t[E]) / 2;
  const double arms = bias.arm_deg_per_h_per_k * arms_k * (1 + bias.arm_growth_per_k * x);
  return {bias.scale * (absolute + gradient_part(bias, t) + arms + wave)};
}

}  // namespace gyrotherm
