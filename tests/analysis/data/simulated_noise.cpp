#include "tests/analysis/data/simulated_noise.hpp"

#include <cmath>

namespace gyrotherm {
namespace {

Eigen::VectorXd normals(Eigen::Index count, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(count, [&] { return normal(random); });
}

/// Flicker noise of rate: white noise through the filter (1 − z⁻¹)^(−1/2) (Kasdin 1995), whose flat Allan variance is
/// 2 ln 2/π times that of the white noise. Its first half, before the filter has a past, is thrown away.
Eigen::VectorXd flicker(Eigen::Index count, std::mt19937_64& random) {
  const Eigen::Index all = 2 * count;
  Eigen::VectorXd reversed_filter(all);
  reversed_filter(all - 1) = 1;
  for (Eigen::Index k = 1; k < all; ++k) {
    reversed_filter(all - 1 - k) = reversed_filter(all - k) * (static_cast<double>(k) - 0.5) / static_cast<double>(k);
  }
  const Eigen::VectorXd white = normals(all, random);
  Eigen::VectorXd filtered(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index past = count + i + 1;
    filtered(i) = reversed_filter.tail(past).dot(white.head(past));
  }
  return filtered;
}

}  // namespace

Eigen::VectorXd simulate(const SimulatedNoise& noise, Eigen::Index samples, double interval_s,
                         std::mt19937_64& random) {
  const double interval_h = interval_s / 3600;
  Eigen::VectorXd rate = noise.N / std::sqrt(interval_h) * normals(samples, random);
  if (noise.Q > 0) {
    const Eigen::VectorXd angle_error = noise.Q * normals(samples + 1, random);
    rate += (angle_error.tail(samples) - angle_error.head(samples)) / interval_h;
  }
  if (noise.B > 0) rate += noise.B * flicker(samples, random);
  if (noise.K > 0) {
    const Eigen::VectorXd steps = noise.K * std::sqrt(interval_h) * normals(samples, random);
    double level = 0;
    for (Eigen::Index k = 0; k < samples; ++k) rate(k) += level += steps(k);
  }
  rate += noise.R * interval_h * Eigen::VectorXd::LinSpaced(samples, 0, static_cast<double>(samples - 1));
  return rate;
}

}  // namespace gyrotherm
