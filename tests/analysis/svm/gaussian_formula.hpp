// SPDX-License-Identifier: Apache-2.0
/// Reference implementation of a sum of Gaussians, which is computed term by term in higher precision.
#pragma once

#include <cmath>

#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// Computes Σ_j w_j exp(−‖z − c_j‖²/(2 s_j²)) at a row z of `points`.
[[nodiscard]] inline double gaussian_formula(const SampleMatrix& points, Eigen::Index point,
                                             const SampleMatrix& centres, const Eigen::VectorXd& widths,
                                             const Eigen::VectorXd& weights) {
  long double sum = 0;
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    long double squares = 0;
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      const long double apart = static_cast<long double>(points(point, k)) - centres(j, k);
      squares += apart * apart;
    }
    const long double width = widths(j);
    sum += weights(j) * std::exp(-squares / (2 * width * width));
  }
  return static_cast<double>(sum);
}

}  // namespace gyrotherm::svm
