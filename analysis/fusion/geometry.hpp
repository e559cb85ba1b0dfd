// SPDX-License-Identifier: Apache-2.0
/// The input axes of the gyros on one fixture: their directions, uncertainties and correlations.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::fusion {

/// Description of one input axis. All rates are compensated, in °/h, and the uncertainties are standard uncertainties
/// (k = 1) of one reading, for any averaging time.
struct InputAxis {
  std::string name;
  /// Unit vector in the axes of the fixture.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  /// Uncertainty that is independent of other axes; above 0.
  double independent_deg_per_h{};
  /// Signed effect of one standard deviation of each shared source on this axis: for a thermometer, its uncertainty
  /// times the model's sensitivity to it. All axes have the same sources in the same order; empty without shared
  /// sources.
  std::vector<double> shared_deg_per_h{};
};

/// The axes as input of the fusion: y = H ω + e, with e normal, of mean 0 and covariance C.
struct Geometry {
  std::vector<std::string> names;
  Eigen::MatrixX3d directions;  ///< H: one row per axis
  /// C, (°/h)²: diag(independent²) + S Sᵀ, S with one column per shared source.
  Eigen::MatrixXd covariance;
  [[nodiscard]] Eigen::Index axes() const { return directions.rows(); }
};

/// Greatest deviation of a direction's length from 1, and smallest permitted ratio of the least to the greatest
/// singular value of H. Below this ratio the axes are in one plane within the accuracy of a fixture.
inline constexpr double kLengthTolerance = 1e-6;
inline constexpr double kLeastSingularShare = 1e-3;

/// Checks axes and combines them. Fails with usage for the first of these: fewer than three axes; an empty or repeated
/// name; a direction that is not finite or not of length 1; an independent uncertainty that is not above 0; shared
/// uncertainties that are not finite or differ in number from those of the first axis; directions in one plane;
/// a covariance that is not positive definite within the accuracy of the computation.
[[nodiscard]] Result<Geometry> make_geometry(const std::vector<InputAxis>& axes);

/// Returns the geometry without one axis. Fails with usage if the others do not span all directions.
[[nodiscard]] Result<Geometry> remove_axis(const Geometry& geometry, Eigen::Index axis);

/// Returns the geometry of means over `count` readings, assuming that independent errors are white and shared errors
/// are constant: the independent uncertainties are divided by √count. Fails like make_geometry().
[[nodiscard]] Result<Geometry> geometry_of_means(std::vector<InputAxis> axes, int count);

}  // namespace gyrotherm::fusion
