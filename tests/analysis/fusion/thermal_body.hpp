// SPDX-License-Identifier: Apache-2.0
/// Eight thermometers on a body with three modes, for the tests of their agreement.
#pragma once

#include <string>
#include <vector>

#include "analysis/fusion/voting.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {

inline constexpr Eigen::Index kThermometers = 8;
inline constexpr int kModes = 3;
inline constexpr double kNoise_k = 0.005, kDrift_k = 0.012;
inline constexpr double kOwn_k = 0.013;  ///< both together

/// Draws temperatures: a common part of tens of kelvins, gradients along and across the body of some kelvins, and the
/// thermometers' own errors.
[[nodiscard]] inline Eigen::RowVectorXd temperatures(Draws& draws, double own_k) {
  Eigen::RowVectorXd row(kThermometers);
  const Eigen::VectorXd ways = draws.normal(kModes);
  for (Eigen::Index j = 0; j < kThermometers; ++j) {
    const double place = 2.0 * static_cast<double>(j) / (kThermometers - 1) - 1;
    row(j) = 20 + 20 * ways(0) + 3 * ways(1) * place + 1.5 * ways(2) * (place * place - 0.4) * (j % 2 == 0 ? 1 : 0.7);
  }
  return row + own_k * draws.normal(kThermometers).transpose();
}

[[nodiscard]] inline ThermometerParity learnt_accord() {
  Draws draws(1000);
  Eigen::MatrixXd record(4000, kThermometers);
  for (Eigen::Index i = 0; i < record.rows(); ++i) record.row(i) = temperatures(draws, kNoise_k);
  const auto parity = learn_thermometer_parity(record, {"A", "B", "C", "D", "E", "F", "G", "H"},
                                               Eigen::VectorXd::Constant(kThermometers, kDrift_k), kModes);
  EXPECT_TRUE(parity) << text(parity.error());
  return *parity;
}

}  // namespace gyrotherm::fusion
