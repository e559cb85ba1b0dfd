// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/correlated_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace gyrotherm::data {
namespace {

/// Correlated noise with the variance 1: white noise, and a first-order process.
struct NoiseShape {
  /// Correlation of the process between neighbouring positions.
  double correlation{};
  /// Variance of the process; that of the white noise is 1 − share.
  double share{};
  double log_prior{};
};

std::vector<NoiseShape> list_noise_shapes(int longest) {
  constexpr double kWhiteOdds = 3;
  std::vector<NoiseShape> shapes{{}};
  std::vector<int> times;
  for (int time = 1; time < longest; time *= 2) times.push_back(time);
  if (longest > 0) times.push_back(longest);
  for (const int time : times)
    for (const double share : {0.1, 0.3, 0.6, 0.9, 1.0}) shapes.push_back({std::exp(-1.0 / time), share});
  const auto others = static_cast<double>(shapes.size() - 1);
  for (NoiseShape& shape : shapes) shape.log_prior = shape.share > 0 ? -std::log(others) : std::log(kWhiteOdds);
  return shapes;
}

double correlation_over(const NoiseShape& shape, int step) { return std::pow(shape.correlation, step); }

/// Computes AᵀΣ⁻¹A for the columns of A, and log|Σ|, by a Kalman filter that makes the columns white.
double whitened_products(const Eigen::MatrixXd& columns, const Eigen::VectorXi& positions, const NoiseShape& shape,
                         Eigen::MatrixXd& products) {
  products.setZero(columns.cols(), columns.cols());
  Eigen::RowVectorXd state = Eigen::RowVectorXd::Zero(columns.cols()), innovation;
  double variance = shape.share, log_determinant = 0;
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    if (k > 0) {
      const double kept = correlation_over(shape, positions(k) - positions(k - 1));
      state *= kept;
      variance = kept * kept * variance + shape.share * (1 - kept * kept);
    }
    innovation = columns.row(k) - state;
    const double total = variance + 1 - shape.share;
    products.noalias() += innovation.transpose() * innovation / total;
    log_determinant += std::log(total);
    state += variance / total * innovation;
    variance *= 1 - variance / total;
  }
  return log_determinant;
}

/// Computes XᵀΣX.
Eigen::MatrixXd covariance_products(const Eigen::MatrixXd& x, const Eigen::VectorXi& positions,
                                    const NoiseShape& shape) {
  Eigen::MatrixXd sum = x.transpose() * x;
  Eigen::RowVectorXd earlier = Eigen::RowVectorXd::Zero(x.cols());
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(x.cols(), x.cols());
  for (Eigen::Index k = 1; k < x.rows(); ++k) {
    earlier = correlation_over(shape, positions(k) - positions(k - 1)) * (earlier + x.row(k - 1));
    cross.noalias() += x.row(k).transpose() * earlier;
  }
  sum += shape.share * (cross + cross.transpose());
  return sum;
}

/// Greatest ratio of the scale of a shape to the one that the size of the residual gives. The likelihood extrapolates
/// the scale from the steps between neighbours; noise of another shape made it 20 times the one that was seen.
constexpr double kMaxRatioToSeen = 2;

/// Restricted log-likelihood of a shape of the noise, and the variances of the coefficients for it.
struct WeighedShape {
  double log_weight{};
  Eigen::VectorXd variances;
};

WeighedShape weigh_shape(const Eigen::MatrixXd& x, const Eigen::VectorXd& residual, const Eigen::VectorXi& positions,
                         const Eigen::MatrixXd& inverse, const NoiseShape& shape) {
  const Eigen::Index count = x.cols();
  Eigen::MatrixXd columns(x.rows(), count + 1), products;
  columns << x, residual;
  const double log_determinant = whitened_products(columns, positions, shape, products);
  const Eigen::LDLT<Eigen::MatrixXd> information(products.topLeftCorner(count, count));
  const Eigen::VectorXd against = products.col(count).head(count);
  const double squares =
      std::max(products(count, count) - against.dot(information.solve(against)), std::numeric_limits<double>::min());
  const auto freedom = static_cast<double>(x.rows() - count);
  const Eigen::MatrixXd leverage = inverse * covariance_products(x, positions, shape);
  const double seen = residual.squaredNorm() / (static_cast<double>(x.rows()) - leverage.trace());
  return {shape.log_prior -
              0.5 * (log_determinant + information.vectorD().array().abs().log().sum() + freedom * std::log(squares)),
          std::min(squares / (freedom - 2), kMaxRatioToSeen * seen) * (leverage * inverse).diagonal()};
}

}  // namespace

CorrelatedFit fit_with_correlated_noise(const Eigen::MatrixXd& x, const Eigen::VectorXd& y,
                                        const Eigen::VectorXi& positions, int longest) {
  assert(x.rows() >= x.cols() + 3 && y.size() == x.rows() && positions.size() == x.rows());
  // Columns of equal size keep the products well conditioned.
  const Eigen::RowVectorXd size = x.colwise().norm();
  const Eigen::MatrixXd scaled = x * size.cwiseInverse().asDiagonal();
  CorrelatedFit fit{.coefficients = scaled.colPivHouseholderQr().solve(y), .u = {}, .residual = {}};
  fit.residual = y - scaled * fit.coefficients;
  const Eigen::MatrixXd inverse = (scaled.transpose() * scaled).inverse();
  std::vector<WeighedShape> all;
  for (const NoiseShape& shape : list_noise_shapes(longest))
    all.push_back(weigh_shape(scaled, fit.residual, positions, inverse, shape));
  const double greatest = std::ranges::max_element(all, {}, &WeighedShape::log_weight)->log_weight;
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(x.cols());
  double weights = 0;
  for (const WeighedShape& one : all) {
    const double weight = std::exp(one.log_weight - greatest);
    variances += weight * one.variances;
    weights += weight;
  }
  fit.u = (variances / weights).cwiseMax(0).cwiseSqrt().cwiseQuotient(size.transpose());
  fit.coefficients = fit.coefficients.cwiseQuotient(size.transpose());
  return fit;
}

}  // namespace gyrotherm::data
