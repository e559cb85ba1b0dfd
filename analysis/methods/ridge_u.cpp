// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/ridge_u.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/linear.hpp"

namespace gyrotherm::methods {
namespace {

/// Returns a root R of the matrix, RᵀR = C. Eigenvalues that rounding made negative are taken as 0.
Eigen::MatrixXd matrix_root(const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  return eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

/// Relative length below which a direction consists of rounding errors of dependent terms.
constexpr double kRelative = 1e-9;

}  // namespace

PenalisedPlane penalised_plane(const Eigen::Ref<const Eigen::MatrixXd>& z, const Eigen::Ref<const Eigen::VectorXd>& y,
                               const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  const Eigen::Index inputs = z.cols();
  assert(z.rows() == y.size() && covariance.rows() == inputs && covariance.cols() == inputs);
  const Eigen::RowVectorXd z_mean = z.colwise().mean();
  const double y_mean = y.mean();
  // The triangle of a QR decomposition determines the same weights as all samples and is much smaller.
  const Eigen::HouseholderQR<Eigen::MatrixXd> samples(z.rowwise() - z_mean);
  const Eigen::Index kept = std::min(z.rows(), inputs);
  const Eigen::VectorXd rotated = samples.householderQ().transpose() * (y.array() - y_mean).matrix();
  Eigen::MatrixXd stacked(kept + inputs, inputs);
  stacked << Eigen::MatrixXd(samples.matrixQR().topRows(kept).triangularView<Eigen::Upper>()),
      std::sqrt(static_cast<double>(z.rows())) * matrix_root(covariance);
  Eigen::VectorXd target = Eigen::VectorXd::Zero(kept + inputs);
  target.head(kept) = rotated.head(kept);
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> whole(stacked.rows(), stacked.cols());
  whole.setThreshold(kRelative);
  whole.compute(stacked);
  const Eigen::MatrixXd basis = whole.householderQ() * Eigen::MatrixXd::Identity(kept + inputs, whole.rank());
  PenalisedPlane plane;
  plane.weights = whole.solve(target);
  plane.b = y_mean - z_mean * plane.weights;
  plane.effective_parameters = 1 + basis.topRows(kept).squaredNorm();
  return plane;
}

PenalisedPlane fit_plane(const FitInput& set) {
  if (set.input_covariance.size() > 0) return penalised_plane(set.x, set.y, set.input_covariance);
  return penalised_plane(set.x, set.y, Eigen::MatrixXd::Zero(set.x.cols(), set.x.cols()));
}

Eigen::VectorXd plane_residual(const FitInput& set) {
  const PenalisedPlane plane = fit_plane(set);
  return set.y - ((set.x * plane.weights).array() + plane.b).matrix();
}

Eigen::MatrixXd slope_penalty(const FitInput& set, double variance) {
  const Eigen::Index inputs = set.x.cols();
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Identity(inputs, inputs) / (kWidestSlope * kWidestSlope);
  if (set.input_covariance.size() > 0) penalty += static_cast<double>(set.x.rows()) / variance * set.input_covariance;
  return penalty;
}

Result<Fit> fit_ridge_u(const FitInput& set, const HyperParameters&, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const PenalisedPlane plane = fit_plane(set);
  Eigen::MatrixXd penalty;
  if (set.input_covariance.size() > 0)
    penalty = std::sqrt(static_cast<double>(set.x.rows())) * matrix_root(set.input_covariance);
  return make_plane_fit(set, {.weights = plane.weights, .b = plane.b}, plane.effective_parameters, penalty);
}

}  // namespace gyrotherm::methods
