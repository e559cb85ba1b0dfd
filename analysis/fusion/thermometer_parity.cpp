// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/thermometer_parity.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "analysis/data/statistics.hpp"

namespace gyrotherm::fusion {

Result<ThermometerParity> thermometer_parity_of(const Eigen::Ref<const Eigen::MatrixXd>& temperature_c,
                                                const std::vector<std::string>& names,
                                                const Eigen::Ref<const Eigen::VectorXd>& uncertainty_k, int modes) {
  constexpr int kRowsOfEach = 10, kLeastLeft = 2;
  const auto wrong = [](std::string what) {
    return failure(FaultKind::usage, "accord of thermometers", std::move(what));
  };
  const Eigen::Index count = temperature_c.cols();
  if (static_cast<Eigen::Index>(names.size()) != count || uncertainty_k.size() != count)
    return wrong(
        fmt::format("{} names and {} uncertainties for {} thermometers", names.size(), uncertainty_k.size(), count));
  if (modes < 1 || count - modes < kLeastLeft)
    return wrong(fmt::format("{} thermometers, and {} ways in which they move together: {} more are needed", count,
                             modes, kLeastLeft));
  if (!(uncertainty_k.minCoeff() > 0) || !uncertainty_k.allFinite())
    return wrong("the uncertainty of a thermometer is not above 0");
  const std::vector<Eigen::Index> rows = data::finite_rows(temperature_c);
  if (static_cast<Eigen::Index>(rows.size()) < kRowsOfEach * count)
    return wrong(fmt::format("{} rows are known, and {} are needed", rows.size(), kRowsOfEach * count));
  const Eigen::MatrixXd known = temperature_c(rows, Eigen::all);
  const Eigen::RowVectorXd mean = known.colwise().mean();
  const Eigen::MatrixXd centred = known.rowwise() - mean;
  Eigen::MatrixXd covariance = centred.transpose() * centred / static_cast<double>(rows.size() - 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> components(covariance);  // the least first
  const Eigen::MatrixXd others = components.eigenvectors().leftCols(count - modes).transpose();
  covariance.diagonal() += uncertainty_k.cwiseAbs2();
  const Eigen::MatrixXd spread = others * covariance * others.transpose();
  return ThermometerParity{.names = names, .mean_c = mean, .whitening = spread.llt().matrixL().solve(others)};
}

}  // namespace gyrotherm::fusion
