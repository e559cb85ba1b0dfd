// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/unexplained_noise.hpp"

#include <cassert>
#include <cmath>

namespace gyrotherm::population {

Eigen::MatrixXd noise_covariance(const UnexplainedNoise& noise, const Eigen::VectorXd& time_s) {
  const double white = std::pow(noise.white_deg_per_h, 2), wander = std::pow(noise.wander_deg_per_h, 2);
  const double turn_on = std::pow(noise.turn_on_deg_per_h, 2);
  Eigen::MatrixXd covariance(time_s.size(), time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i)
    for (Eigen::Index j = 0; j < time_s.size(); ++j)
      covariance(i, j) =
          (i == j ? white : 0) + wander * std::exp(-std::abs(time_s(i) - time_s(j)) / noise.wander_time_s) + turn_on;
  return covariance;
}

WhitenedColumns whiten(const UnexplainedNoise& noise, const Eigen::VectorXd& time_s, const Eigen::MatrixXd& columns) {
  assert(time_s.size() == columns.rows() && noise.white_deg_per_h > 0 && noise.wander_time_s > 0);
  const double white = std::pow(noise.white_deg_per_h, 2), wander = std::pow(noise.wander_deg_per_h, 2);
  WhitenedColumns whitened{.columns = Eigen::MatrixXd(columns.rows(), columns.cols())};
  // The state consists of wander and turn-on. Their covariance is common to all columns; their estimates have one row
  // each.
  Eigen::Matrix2d covariance = Eigen::Vector2d(wander, std::pow(noise.turn_on_deg_per_h, 2)).asDiagonal();
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(2, columns.cols());
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    if (k > 0) {
      assert(time_s(k) > time_s(k - 1));
      const double kept = std::exp(-(time_s(k) - time_s(k - 1)) / noise.wander_time_s);
      state.row(0) *= kept;
      covariance.row(0) *= kept;
      covariance.col(0) *= kept;
      covariance(0, 0) += wander * (1 - kept * kept);
    }
    const Eigen::Vector2d with = covariance.rowwise().sum();
    const double variance = with.sum() + white;
    const Eigen::RowVectorXd innovation = columns.row(k) - state.colwise().sum();
    state += with / variance * innovation;
    covariance -= with * with.transpose() / variance;
    whitened.columns.row(k) = innovation / std::sqrt(variance);
    whitened.log_determinant += std::log(variance);
  }
  return whitened;
}

}  // namespace gyrotherm::population
