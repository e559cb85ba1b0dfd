// SPDX-License-Identifier: Apache-2.0
/// Who is at fault when a compensated axis departs from what is expected of it: the gyro, which hopped, or a
/// thermometer, by which the thermal model was misled. The thermometers' accord among themselves votes with the axes.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/thermometer_parity.hpp"

namespace gyrotherm::fusion {

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
