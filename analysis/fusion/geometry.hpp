// SPDX-License-Identifier: Apache-2.0
/// The input axes of the gyros on one fixture: where each points, and how well each is known by itself and together
/// with the others.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::fusion {

/// One input axis as it is described. All rates are compensated ones, in °/h, and their uncertainties are standard ones
/// (k = 1) of one reading, whatever time that is a mean over.
struct InputAxis {
  std::string name;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit vector, in the axes of the fixture
  double independent_deg_per_h{};                       ///< what no other axis shares; above 0
  /// What one standard deviation of each source that axes share does to this one, with its sign: of a thermometer, its
  /// uncertainty by the model's sensitivity to it. As many for each axis, in the same order; none if nothing is shared.
  std::vector<double> shared_deg_per_h{};
};

/// The axes as fusion needs them: y = H ω + e, e normal of mean 0 and covariance C.
struct Geometry {
  std::vector<std::string> names;
  Eigen::MatrixX3d directions;  ///< H: a row per axis
  Eigen::MatrixXd covariance;   ///< C, (°/h)²: diag(independent²) + S Sᵀ, S a column per shared source
  [[nodiscard]] Eigen::Index axes() const { return directions.rows(); }
};

/// How far a direction's length may be from 1, and how small the least of the singular values of H may be beside the
/// greatest: beyond that the axes lie in a plane, as far as a fixture can be measured.
inline constexpr double kLengthTolerance = 1e-6;
inline constexpr double kLeastSingularShare = 1e-3;

/// Checks axes and puts them together. Fails with usage at the first of: fewer than three axes; a name that is empty or
/// not the only one; a direction that is not finite or not of length 1; an independent uncertainty that is not above 0;
/// shared ones that are not finite or not as many as the first axis has; directions that lie in a plane.
[[nodiscard]] Result<Geometry> geometry_of(const std::vector<InputAxis>& axes);

/// The geometry without one axis. Fails with usage if the others do not span space.
[[nodiscard]] Result<Geometry> without(const Geometry& geometry, Eigen::Index axis);

/// The geometry of means over `count` readings, if what axes do not share is white and what they share stands still:
/// the independent uncertainties are divided by the root of the count. Fails as geometry_of() does.
[[nodiscard]] Result<Geometry> geometry_of_means(std::vector<InputAxis> axes, int count);

}  // namespace gyrotherm::fusion
