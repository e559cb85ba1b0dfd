// SPDX-License-Identifier: Apache-2.0
/// The working gyro at rest in still or moving air: the temperature field, consistent with the temperature-dependent
/// conductivity of the cabinet's air.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "core/result.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

struct SteadyOptions {
  double ambient_c = 20;
  /// If empty, the model's film coefficient in still air; in block mode, that of the block.
  std::optional<double> film_w_per_m2_k{};
  /// Fixed coefficients, which make the problem linear. If empty, the coefficients depend on the temperatures.
  std::optional<ThermalCoefficients> coefficients{};
  /// Tolerance of the air temperature between two rounds.
  double tolerance_k = 1e-4;
  int most_rounds = 30;
};

struct ExtremePoint {
  double temperature_c{};
  std::array<double, 3> at_m{};
  GyroPart part{};
};

struct SteadyState {
  /// Temperature of each node.
  Eigen::VectorXd field_c;
  /// Outputs; the ambient temperature for a part that is not in the mesh.
  std::array<double, kThermalOutputs> outputs_c{};
  ThermalCoefficients coefficients{};
  /// Mean temperature of block and shell, for which the air conductivity was computed.
  double air_c{};
  double power_in_w{};
  /// Heat flow through the film.
  double power_out_w{};
  /// Hottest and coldest points of all solids; gas and air are excluded.
  ExtremePoint hottest, coldest;
  ExtremePoint block_hottest, block_coldest;
  /// Number of rounds that adjusted the air temperature, and of linear-solver iterations in all rounds.
  int rounds{};
  int iterations{};
  std::size_t unknowns{};
};

/// Computes the steady state. Fails with numeric if a linear solve or the rounds do not converge.
[[nodiscard]] Result<SteadyState> steady_state(const GyroModel& model, const GyroMesh& mesh,
                                               const SteadyOptions& options = {});

/// Returns the mean of A, B, C minus the mean of F, G, H, which the paper states as 3.5 K.
[[nodiscard]] double gain_difference_k(std::span<const double, kThermalOutputs> outputs_c);

/// Returns the temperature of the gap air: the mean of block and shell.
[[nodiscard]] double air_temperature_c(std::span<const double, kThermalOutputs> outputs_c);

}  // namespace gyrotherm::thermal
