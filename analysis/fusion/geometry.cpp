// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/geometry.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace gyrotherm::fusion {
namespace {

tl::unexpected<Fault> refuse(std::string where, std::string what) {
  return failure(FaultKind::usage, std::move(where), std::move(what));
}

Result<void> check_axis(const InputAxis& axis, std::size_t shared) {
  const std::string where = "axis " + axis.name;
  if (!axis.direction.allFinite()) return refuse(where, "its direction is not finite");
  if (const double length = axis.direction.norm(); std::abs(length - 1) > kLengthTolerance)
    return refuse(where, fmt::format("its direction has the length {:.9g}, not 1", length));
  if (!std::isfinite(axis.independent_deg_per_h) || axis.independent_deg_per_h <= 0)
    return refuse(where, fmt::format("its own uncertainty is {} °/h, not above 0", axis.independent_deg_per_h));
  if (axis.shared_deg_per_h.size() != shared)
    return refuse(where, fmt::format("it has {} shared uncertainties, but the first axis has {}",
                                     axis.shared_deg_per_h.size(), shared));
  if (!std::ranges::all_of(axis.shared_deg_per_h, [](double value) { return std::isfinite(value); }))
    return refuse(where, "a shared uncertainty is not finite");
  return {};
}

Result<void> check_span(const Eigen::MatrixX3d& directions) {
  if (directions.rows() < 3)
    return refuse("axes", fmt::format("{} given, a rate vector needs at least 3", directions.rows()));
  const Eigen::Vector3d values = Eigen::JacobiSVD<Eigen::MatrixXd>(directions).singularValues();
  if (values(2) < kLeastSingularShare * values(0))
    return refuse("axes", fmt::format("they lie in a plane: the singular values of their directions are {:.3g}, "
                                      "{:.3g} and {:.3g}",
                                      values(0), values(1), values(2)));
  return {};
}

/// Returns whether the Cholesky factor exists and has no diagonal element that consists only of rounding errors.
bool is_well_conditioned(const Eigen::MatrixXd& covariance) {
  constexpr double kRounding = 1e-13;
  if (!covariance.allFinite()) return false;
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  return factor.info() == Eigen::Success &&
         (factor.matrixLLT().diagonal().array().square() > kRounding * covariance.diagonal().array()).all();
}

}  // namespace

Result<Geometry> make_geometry(const std::vector<InputAxis>& axes) {
  const auto count = static_cast<Eigen::Index>(axes.size());
  const std::size_t shared = axes.empty() ? 0 : axes.front().shared_deg_per_h.size();
  Geometry geometry{
      .names = {}, .directions = Eigen::MatrixX3d(count, 3), .covariance = Eigen::MatrixXd::Zero(count, count)};
  Eigen::MatrixXd sources(count, static_cast<Eigen::Index>(shared));
  for (Eigen::Index i = 0; i < count; ++i) {
    const InputAxis& axis = axes[static_cast<std::size_t>(i)];
    if (axis.name.empty()) return refuse("axes", fmt::format("number {} has no name", i + 1));
    if (std::ranges::count(geometry.names, axis.name) > 0) return refuse("axis " + axis.name, "duplicate name");
    if (auto checked = check_axis(axis, shared); !checked) return failure(checked.error());
    geometry.names.push_back(axis.name);
    geometry.directions.row(i) = axis.direction;
    geometry.covariance(i, i) = axis.independent_deg_per_h * axis.independent_deg_per_h;
    for (std::size_t k = 0; k < shared; ++k) sources(i, static_cast<Eigen::Index>(k)) = axis.shared_deg_per_h[k];
  }
  if (auto checked = check_span(geometry.directions); !checked) return failure(checked.error());
  geometry.covariance += sources * sources.transpose();
  if (!is_well_conditioned(geometry.covariance))
    return refuse("axes",
                  "their covariance is not positive definite: an own uncertainty is too small beside the "
                  "shared ones, or too small or too large for its square");
  return geometry;
}

Result<Geometry> remove_axis(const Geometry& geometry, Eigen::Index axis) {
  assert(axis >= 0 && axis < geometry.axes());
  std::vector<Eigen::Index> left;
  for (Eigen::Index i = 0; i < geometry.axes(); ++i)
    if (i != axis) left.push_back(i);
  Geometry remaining{.names = geometry.names,
                     .directions = geometry.directions(left, Eigen::all),
                     .covariance = geometry.covariance(left, left)};
  remaining.names.erase(remaining.names.begin() + axis);
  if (auto checked = check_span(remaining.directions); !checked)
    return refuse("axes without " + geometry.names[static_cast<std::size_t>(axis)], checked.error().what);
  return remaining;
}

Result<Geometry> geometry_of_means(std::vector<InputAxis> axes, int count) {
  assert(count >= 1);
  for (InputAxis& axis : axes) axis.independent_deg_per_h /= std::sqrt(static_cast<double>(count));
  return make_geometry(axes);
}

}  // namespace gyrotherm::fusion
