// SPDX-License-Identifier: Apache-2.0
/// Eight thermometers on a body with three common modes, for tests of the thermometer parity.
#pragma once

#include <string>
#include <vector>

#include "analysis/fusion/voting.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {

inline constexpr Eigen::Index kThermometers = 8;
inline constexpr int kModes = 3;
inline constexpr double kNoise_k = 0.005, kDrift_k = 0.012;
inline constexpr double kOwn_k = 0.013;  ///< root sum of squares

/// Draws temperatures: a common part of tens of kelvins, gradients along and across the body of a few kelvins, and
/// independent thermometer errors with the standard deviation `own_k`.
[[nodiscard]] inline Eigen::RowVectorXd temperatures(Draws& draws, double own_k) {
  Eigen::RowVectorXd row(kThermometers);
  const Eigen::VectorXd modes = draws.normal(kModes);
  for (Eigen::Index j = 0; j < kThermometers; ++j) {
    const double position = 2.0 * static_cast<double>(j) / (kThermometers - 1) - 1;
    row(j) = 20 + 20 * modes(0) + 3 * modes(1) * position +
             1.5 * modes(2) * (position * position - 0.4) * (j % 2 == 0 ? 1 : 0.7);
  }
  return row + own_k * draws.normal(kThermometers).transpose();
}

[[nodiscard]] inline ThermometerParity learnt_thermometer_parity() {
  Draws draws(1000);
  Eigen::MatrixXd record(4000, kThermometers);
  for (Eigen::Index i = 0; i < record.rows(); ++i) record.row(i) = temperatures(draws, kNoise_k);
  const auto parity = learn_thermometer_parity(record, {"A", "B", "C", "D", "E", "F", "G", "H"},
                                               Eigen::VectorXd::Constant(kThermometers, kDrift_k), kModes);
  EXPECT_TRUE(parity) << text(parity.error());
  return *parity;
}

}  // namespace gyrotherm::fusion
