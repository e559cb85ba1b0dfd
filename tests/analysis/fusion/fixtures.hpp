// SPDX-License-Identifier: Apache-2.0
/// Fixtures with three to six axes, and random draws for their errors.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "analysis/fusion/geometry.hpp"

namespace gyrotherm::fusion {

inline constexpr int kSeeds = 20;
inline constexpr double kDegree = std::numbers::pi / 180;  ///< rad

[[nodiscard]] inline InputAxis axis(const std::string& name, double x, double y, double z, double uncertainty) {
  return {.name = name, .direction = Eigen::Vector3d(x, y, z).normalized(), .independent_deg_per_h = uncertainty};
}

[[nodiscard]] inline std::vector<InputAxis> triad_axes(double uncertainty) {
  return {axis("x", 1, 0, 0, uncertainty), axis("y", 0, 1, 0, uncertainty), axis("z", 0, 0, 1, uncertainty)};
}

/// Returns the triad and a fourth axis at equal angles to its axes.
[[nodiscard]] inline std::vector<InputAxis> tetrad_axes(double uncertainty) {
  auto axes = triad_axes(uncertainty);
  axes.push_back(axis("skew", 1, 1, 1, uncertainty));
  return axes;
}

/// Returns the normals of the six pairs of faces of a dodecahedron. The cosine between any two axes is ± 1/√5.
[[nodiscard]] inline std::vector<InputAxis> dodecahedron_axes(double uncertainty) {
  const double golden = (1 + std::sqrt(5)) / 2;
  return {axis("a", golden, 1, 0, uncertainty), axis("b", golden, -1, 0, uncertainty),
          axis("c", 0, golden, 1, uncertainty), axis("d", 0, golden, -1, uncertainty),
          axis("e", 1, 0, golden, uncertainty), axis("f", -1, 0, golden, uncertainty)};
}

[[nodiscard]] inline Geometry valid_geometry(const std::vector<InputAxis>& axes) {
  const auto geometry = make_geometry(axes);
  EXPECT_TRUE(geometry) << text(geometry.error());
  return *geometry;
}

/// Returns six axes without symmetry, with different uncertainties and two shared sources of uncertainty.
[[nodiscard]] inline std::vector<InputAxis> uneven_axes() {
  std::vector<InputAxis> axes = {axis("a", 1, 0.1, 0, 0.01), axis("b", 0, 1, 0.2, 0.02),  axis("c", -0.3, 0, 1, 0.015),
                                 axis("d", 1, 1, 1, 0.03),   axis("e", 1, -1, 0.5, 0.01), axis("f", 0.2, 1, -2, 0.012)};
  double share = 0.004;
  for (InputAxis& one : axes) {
    one.shared_deg_per_h = {share, 0.01 - share};
    share += 0.003;
  }
  return axes;
}

/// Normally distributed random vectors.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed) {}
  [[nodiscard]] Eigen::VectorXd normal(Eigen::Index count) {
    return Eigen::VectorXd::NullaryExpr(count, [this] { return normal_(random_); });
  }
  /// Draws a vector with mean 0 and this covariance, which may be singular.
  [[nodiscard]] Eigen::VectorXd correlated_normal(const Eigen::MatrixXd& covariance) {
    const Eigen::LDLT<Eigen::MatrixXd> factor(covariance);
    const Eigen::VectorXd scaled = factor.vectorD().cwiseMax(0).cwiseSqrt().cwiseProduct(normal(covariance.rows()));
    return factor.transpositionsP().transpose() * (factor.matrixL() * scaled);
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// Returns the standard deviation of the relative frequency of an event with this probability in `count` trials.
[[nodiscard]] inline double relative_frequency_std(double probability, double count) {
  return std::sqrt(probability * (1 - probability) / count);
}

}  // namespace gyrotherm::fusion
