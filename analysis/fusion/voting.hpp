// SPDX-License-Identifier: Apache-2.0
/// Decision between a gyro and a thermometer as the cause when a compensated axis departs from its expected rate: the
/// gyro may have hopped, or a thermometer may have misled the thermal model. The agreement of the thermometers with
/// each other is tested together with the axes.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "analysis/fusion/fault_test.hpp"
#include "core/result.hpp"

namespace gyrotherm::fusion {

/// Agreement of thermometers: W (T − mean) is N(0, I). The thermometers are on one body, whose temperatures have a few
/// common modes; deviations from these modes are attributed to single thermometers.
struct ThermometerParity {
  std::vector<std::string> names;
  Eigen::RowVectorXd mean_c;
  /// W, (K − modes) × K, per K.
  Eigen::MatrixXd whitening;
  [[nodiscard]] FaultTest test() const { return {names, whitening}; }
  [[nodiscard]] Eigen::VectorXd vector(const Eigen::Ref<const Eigen::RowVectorXd>& temperature_c) const {
    return whitening * (temperature_c - mean_c).transpose();
  }
};

/// Learns the agreement from a record without faults: cluster means, one row each; rows that are not finite are
/// ignored. The modes of the body are the first `modes` principal components of the record. The other components are
/// tested by their own spread in the record, plus the thermometers' uncertainty since then (K, one each): W = M⁻¹ E, E
/// the rows of the other components, M Mᵀ = E (S + diag u²) Eᵀ, S the covariance of the record (Jackson and Mudholkar,
/// Technometrics 21 (1979) 341; isolation of the thermometer by the explained part: Dunia, Qin, Edgar and McAvoy, AIChE
/// J. 42 (1996) 2797, and fault_test.hpp). Normality is an approximation: the temperatures of a body outside its modes
/// are not normally distributed, so the record should cover all conditions of use.
///
/// At least two components must remain; otherwise no thermometer can be distinguished from another. Fails with usage if
/// fewer remain, if the names or uncertainties do not match the columns in number, if an uncertainty is not above 0, or
/// if there are fewer than ten rows per thermometer.
[[nodiscard]] Result<ThermometerParity> learn_thermometer_parity(const Eigen::Ref<const Eigen::MatrixXd>& temperature_c,
                                                                 const std::vector<std::string>& names,
                                                                 const Eigen::Ref<const Eigen::VectorXd>& uncertainty_k,
                                                                 int modes);

/// Axes and thermometers of a vote.
struct Voters {
  std::vector<std::string> axes;
  /// Whitens departures of the axes from their expected rates. In motion it is V of compute_gains(): no rate is
  /// expected, and only the parity is observed. At rest it is W of rest_test(): each axis is compared with its own
  /// thermal prediction.
  Eigen::MatrixXd whitening;
  /// Sensitivity of each axis's thermal model (rows) to each thermometer.
  Eigen::MatrixXd sensitivity_deg_per_h_per_k;
  ThermometerParity thermometers;
};

/// Returns the joint test. Its vector consists of the vector of the axes, followed by the vector of the thermometers. A
/// bias of axis i affects only the axes' part, by W e_i. A thermometer j that reads 1 K too high makes each prediction
/// too high by its sensitivity to j and affects both parts, by (−W s_j, W_T e_j). The candidates are the axes, with
/// faults in °/h, followed by the thermometers, with faults in K. The two parts are treated as independent: thermometer
/// uncertainty that is common to several axes is assumed to be small compared with a fault.
[[nodiscard]] FaultTest joint_test(const Voters& voters);

enum class VerdictKind {
  accord,
  /// An axis departs from its prediction, and the thermometers agree.
  gyro_hop,
  /// The predictions depart, and one thermometer disagrees with the others.
  broken_thermometer,
  /// There is a fault, but an axis and a thermometer explain it equally well, or no single candidate explains it.
  undecided
};
[[nodiscard]] const char* name(VerdictKind kind);

struct Verdict {
  VerdictKind kind{};
  /// Axis or thermometer; empty if it cannot be distinguished from others of its kind.
  std::string who{};
  /// Size of the fault and its standard deviation, °/h or K.
  double size{}, size_std{};
  /// A sentence with the values on which the verdict is based.
  std::string reason{};
  Finding joint, of_axes, of_thermometers;
};

/// Decides by the joint test only; the false-alarm probability therefore applies to the vote as a whole. The parts are
/// examined only for the text of the reason. While a four-axis fixture moves, the test cannot determine which axis
/// hopped, so the verdict is a hop without an axis; at rest the verdict names the axis. All numbers must be finite.
[[nodiscard]] Verdict vote(const Voters& voters, const Eigen::Ref<const Eigen::VectorXd>& departures_deg_per_h,
                           const Eigen::Ref<const Eigen::RowVectorXd>& temperature_c, const TestOptions& options = {});

}  // namespace gyrotherm::fusion
