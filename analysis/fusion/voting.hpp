// SPDX-License-Identifier: Apache-2.0
/// Who is at fault when a compensated axis departs from what is expected of it: the gyro, which hopped, or a
/// thermometer, by which the thermal model was misled. The thermometers' accord among themselves votes with the axes.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fusion/fault_test.hpp"
#include "core/result.hpp"

namespace gyrotherm::fusion {

/// The accord of thermometers: W (T − mean) is N(0, I). They are on one body, whose temperatures move together in a few
/// ways; what they show beyond these is their own.
struct ThermometerParity {
  std::vector<std::string> names;
  Eigen::RowVectorXd mean_c;
  Eigen::MatrixXd whitening;  ///< W, (K − modes) × K, per K
  [[nodiscard]] FaultTest test() const { return {names, whitening}; }
  [[nodiscard]] Eigen::VectorXd vector(const Eigen::Ref<const Eigen::RowVectorXd>& temperature_c) const {
    return whitening * (temperature_c - mean_c).transpose();
  }
};

/// Learns the accord from a record in which nothing is at fault: cluster means, a row each, of which rows that are not
/// finite are left out. The ways in which the body moves are the first `modes` principal components of the record; what
/// the others leave is tested by its own spread there, to which the thermometers' uncertainty since then is added (K,
/// one each): W = M⁻¹ E, E the rows of the other components, M Mᵀ = E (S + diag u²) Eᵀ, S the covariance of the record
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

/// What takes part in a vote.
struct Voters {
  std::vector<std::string> axes;
  /// Whitens departures of the axes, compensated rates less what is expected of them: V of gains_of() in motion, where
  /// nothing is expected and the parity alone is seen; W of rest_test() at rest, where each axis stands against its own
  /// thermal prediction.
  Eigen::MatrixXd whitening;
  Eigen::MatrixXd sensitivity_deg_per_h_per_k;  ///< of each axis's thermal model (rows) to each thermometer
  ThermometerParity thermometers;
};

/// One test of both: the vector is that of the axes above that of the thermometers. A bias of axis i shows in the
/// first alone, by W e_i; a thermometer j that is 1 K too high makes each prediction too high by its sensitivity, and
/// shows in both, by (−W s_j, W_T e_j). Axes come first among the candidates, in °/h, then thermometers, in K. The two
/// parts are independent: an uncertainty of thermometers that is shared by axes is taken to be small beside a fault.
[[nodiscard]] FaultTest joint_test(const Voters& voters);

enum class VerdictKind {
  accord,              ///< nothing is at fault
  gyro_hop,            ///< an axis departs from its prediction, and the thermometers are in accord
  broken_thermometer,  ///< the predictions depart, and so does one thermometer from the others
  undecided            ///< something is at fault, and an axis and a thermometer explain it alike, or nobody alone does
};
[[nodiscard]] const char* name(VerdictKind kind);

struct Verdict {
  VerdictKind kind{};
  std::string who{};          ///< the axis or thermometer; empty if it cannot be told from others of its kind
  double size{}, size_std{};  ///< of its fault, °/h or K
  std::string reason{};       ///< a sentence with the figures that decided
  Finding joint, of_axes, of_thermometers;
};

/// Judges by one test, the joint one, so that the false-alarm probability is that of a vote and not of its parts; these
/// are examined beside it for the reason that is given. Four axes in motion cannot say which of them hopped: the
/// verdict is then a hop of nobody. At rest they can. All numbers are finite.
[[nodiscard]] Verdict vote(const Voters& voters, const Eigen::Ref<const Eigen::VectorXd>& departures_deg_per_h,
                           const Eigen::Ref<const Eigen::RowVectorXd>& temperature_c, const TestOptions& options = {});

}  // namespace gyrotherm::fusion
