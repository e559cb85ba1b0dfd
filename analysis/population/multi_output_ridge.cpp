// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/multi_output_ridge.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "analysis/methods/ridge_u.hpp"

namespace gyrotherm::population {
namespace {

tl::unexpected<Fault> refuse_outputs(FaultKind kind, std::string what) {
  return failure(kind, "multi-output ridge", std::move(what));
}

Result<void> check_outputs(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, const Eigen::MatrixXd& penalty) {
  if (z.rows() != y.rows() || z.cols() == 0 || y.cols() == 0) {
    return refuse_outputs(FaultKind::usage, fmt::format("inputs are {} × {}, targets are {} × {}", z.rows(), z.cols(),
                                                        y.rows(), y.cols()));
  }
  if (z.rows() < 2) return refuse_outputs(FaultKind::usage, "at least two clusters are needed");
  if (penalty.rows() != z.cols() || penalty.cols() != z.cols())
    return refuse_outputs(FaultKind::usage, "the penalty is not inputs × inputs");
  if (!z.allFinite() || !y.allFinite() || !penalty.allFinite())
    return refuse_outputs(FaultKind::usage, "a value is not finite");
  return {};
}

/// Q, and the diagonal of D.
struct Diagonals {
  Eigen::MatrixXd combinations;
  Eigen::VectorXd noise;
};

Result<Diagonals> diagonalise(const OutputCovariances& between, Eigen::Index outputs) {
  for (const Eigen::MatrixXd* covariance : {&between.noise, &between.slopes}) {
    if (covariance->rows() != outputs || covariance->cols() != outputs)
      return refuse_outputs(FaultKind::usage, "a covariance is not outputs × outputs");
    if (!covariance->allFinite()) return refuse_outputs(FaultKind::usage, "a covariance is not finite");
    if (covariance->llt().info() != Eigen::Success)
      return refuse_outputs(FaultKind::numeric, "a covariance is not positive definite");
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(between.noise, between.slopes);
  if (eigen.info() != Eigen::Success)
    return refuse_outputs(FaultKind::numeric, "the covariances cannot be diagonalised together");
  return Diagonals{eigen.eigenvectors(), eigen.eigenvalues()};
}

}  // namespace

Result<MultiOutputPlanes> multi_output_ridge(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y,
                                             const Eigen::MatrixXd& penalty, const OutputCovariances& between) {
  if (const auto checked = check_outputs(z, y, penalty); !checked) return failure(checked.error());
  const auto diagonals = diagonalise(between, y.cols());
  if (!diagonals) return failure(diagonals.error());
  const Eigen::MatrixXd combined = y * diagonals->combinations;
  MultiOutputPlanes planes{.weights = Eigen::MatrixXd(z.cols(), y.cols()),
                           .b = Eigen::RowVectorXd(y.cols()),
                           .effective_parameters = Eigen::VectorXd(y.cols())};
  for (Eigen::Index k = 0; k < y.cols(); ++k) {
    const auto plane = methods::penalised_plane(z, combined.col(k), diagonals->noise(k) * penalty);
    planes.weights.col(k) = plane.weights;
    planes.b(k) = plane.b;
    planes.effective_parameters(k) = plane.effective_parameters;
  }
  const Eigen::MatrixXd back = diagonals->combinations.inverse();
  planes.weights = planes.weights * back;
  planes.b = planes.b * back;
  return planes;
}

Result<EstimatedPlanes> multi_output_ridge(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y,
                                           const Eigen::MatrixXd& penalty) {
  if (const auto checked = check_outputs(z, y, penalty); !checked) return failure(checked.error());
  const Eigen::Index outputs = y.cols();
  const auto identity = Eigen::MatrixXd::Identity(outputs, outputs);
  const Eigen::MatrixXd centred = y.rowwise() - y.colwise().mean();
  Eigen::VectorXd variance = centred.colwise().squaredNorm().transpose() / static_cast<double>(y.rows() - 1);
  Eigen::MatrixXd noise;
  // The first step uses the variance of the bias, the second that of the residuals.
  for (int step = 0; step < 2; ++step) {
    Eigen::MatrixXd residual(y.rows(), outputs);
    double parameters = 0;
    for (Eigen::Index j = 0; j < outputs; ++j) {
      const auto plane = methods::penalised_plane(z, y.col(j), variance(j) * penalty);
      residual.col(j) = y.col(j) - ((z * plane.weights).array() + plane.b).matrix();
      parameters += plane.effective_parameters / static_cast<double>(outputs);
    }
    const double left = static_cast<double>(y.rows()) - parameters;
    constexpr double kRounding = 1e-9;
    if (!(left > kRounding * static_cast<double>(y.rows())))
      return refuse_outputs(FaultKind::usage, "there are fewer clusters than coefficients");
    noise = residual.transpose() * residual / left;
    variance = noise.diagonal();
  }
  auto planes = multi_output_ridge(z, y, penalty, {noise, identity});
  if (!planes) return failure(planes.error());
  return EstimatedPlanes{std::move(*planes), std::move(noise)};
}

}  // namespace gyrotherm::population
