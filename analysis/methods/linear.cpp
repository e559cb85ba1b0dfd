// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/linear.hpp"

#include <fmt/format.h>

#include <Eigen/QR>

#include "analysis/methods/held_out.hpp"

namespace gyrotherm::methods {

Result<Fit> fit_linear(const FitInput& set, const HyperParameters&, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  Eigen::MatrixXd design(set.x.rows(), set.x.cols() + 1);
  design << set.x, Eigen::VectorXd::Ones(set.x.rows());
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr;
  qr.setThreshold(1e-9);
  qr.compute(design);
  if (set.x.rows() <= qr.rank()) {
    return failure(FaultKind::usage, "least squares",
                   fmt::format("{} clusters are too few for {} coefficients", set.x.rows(), qr.rank()));
  }
  const Eigen::VectorXd coefficients = qr.solve(set.y);
  return Fit{.function = LinearModel{.weights = coefficients.head(set.x.cols()), .b = coefficients(set.x.cols())},
             .effective_parameters = static_cast<double>(qr.rank()),
             .particulars = {}};
}

}  // namespace gyrotherm::methods
