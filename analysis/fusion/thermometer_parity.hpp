// SPDX-License-Identifier: Apache-2.0
/// Thermometers against each other: they stand on one body, whose temperatures move together in a few ways, and what
/// they show beyond these is theirs.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/fusion/fault_test.hpp"
#include "core/result.hpp"

namespace gyrotherm::fusion {

/// What thermometers show of each other: W (T − mean) is N(0, I) while they are in accord.
struct ThermometerParity {
  std::vector<std::string> names;
  Eigen::RowVectorXd mean_c;
  Eigen::MatrixXd whitening;  ///< W, (K − modes) × K, per K
  [[nodiscard]] FaultTest test() const { return {names, whitening}; }
  [[nodiscard]] Eigen::VectorXd vector(const Eigen::Ref<const Eigen::RowVectorXd>& temperature_c) const {
    return whitening * (temperature_c - mean_c).transpose();
  }
};

/// Learns it from a record in which nothing is at fault: cluster means, a row each, of which rows that are not finite
/// are left out. The ways in which the body moves are the first `modes` principal components of the record; what the
/// others leave is tested by its own spread there, to which the thermometers' uncertainty since then is added (K, one
/// each): W = M⁻¹ E, E the rows of the other components, M Mᵀ = E (S + diag u²) Eᵀ, S the covariance of the record
/// (Jackson and Mudholkar, Technometrics 21 (1979) 341; which thermometer it is, by what its fault explains: Dunia,
/// Qin, Edgar and McAvoy, AIChE J. 42 (1996) 2797, and fault_test.hpp). That this is normal is an assumption: what a
/// body leaves of its components is not, and the record should hold all that the body will go through.
///
/// Two components must be left, else no thermometer can be told from another. Fails with usage if there are fewer, the
/// names or uncertainties are not as many as the columns, an uncertainty is not above 0, or there are fewer than ten
/// rows for each thermometer.
[[nodiscard]] Result<ThermometerParity> thermometer_parity_of(const Eigen::Ref<const Eigen::MatrixXd>& temperature_c,
                                                              const std::vector<std::string>& names,
                                                              const Eigen::Ref<const Eigen::VectorXd>& uncertainty_k,
                                                              int modes);

}  // namespace gyrotherm::fusion
