// SPDX-License-Identifier: Apache-2.0
/// The response of a unit's thermometers to the set point of the chamber and to the unit's own power: the temperatures
/// that a program will cause, predicted before it runs.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/planning/program_path.hpp"
#include "core/result.hpp"

namespace gyrotherm::planning {

/// T = offset + Σ_j gain_j F_j + Σ_j heating_j P_j for each thermometer. F_j follows the set point with the time
/// constant τ_j, and P_j follows the power (1 on, 0 off). Both start in equilibrium with the unit on. This is a Foster
/// network of a body with several nodes; the chamber's own lag is part of it.
struct ThermalResponse {
  std::vector<std::string> thermometers;
  Eigen::VectorXd time_constants_s;  ///< τ_j
  Eigen::MatrixXd gain;              ///< time constants × thermometers; each column adds up to about 1
  Eigen::MatrixXd heating_k;         ///< time constants × thermometers
  Eigen::RowVectorXd offset_c;       ///< one per thermometer
  /// Root mean square of the difference to the recorded temperatures, K; NaN if nothing was recorded.
  double rms_k{};
};

/// Returns a response with the time constants of the ring laser gyro of the reference simulation, for a unit of which
/// nothing is recorded. The slowest time constant there is 46 min.
[[nodiscard]] ThermalResponse typical_response(const std::vector<std::string>& thermometers);

/// Fits the response to the gradient thermometers of a record by least squares. Where a record says little, as after an
/// hour at one temperature, the fit stays near typical_response(). Fails with usage if the record has no gradient
/// thermometer or no set points.
[[nodiscard]] Result<ThermalResponse> fit_response(const data::Dataset& dataset, double length_s = 100);

/// Predicts the temperatures along a path that starts in equilibrium, °C: rows of the path × thermometers.
[[nodiscard]] Eigen::MatrixXd predict_temperatures(const ThermalResponse& response, const ProgramPath& path);

/// Returns the clusters that a run of the path would have from row `first` on, without those where the unit is off. The
/// bias is 0. The history is that of the whole path.
[[nodiscard]] data::Clusters predict_clusters(const ThermalResponse& response, const ProgramPath& path,
                                              Eigen::Index first = 0);

}  // namespace gyrotherm::planning
