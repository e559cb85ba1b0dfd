// SPDX-License-Identifier: Apache-2.0
/// The working gyro at rest in still or moving air: temperature everywhere, with the conductivity of the cabinet's air
/// at the temperature that comes out.
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
  std::optional<double> film_w_per_m2_k{};            ///< absent: the model's still film, in block mode its block film
  std::optional<ThermalCoefficients> coefficients{};  ///< given: kept, whatever the temperatures (the linear problem)
  double tolerance_k = 1e-4;                          ///< of the air's temperature between two rounds
  int most_rounds = 30;
};

struct ExtremePoint {
  double temperature_c{};
  std::array<double, 3> at_m{};  ///< x, y, z
  GyroPart part{};
};

struct SteadyState {
  Eigen::VectorXd field_c;                          ///< by node
  std::array<double, kThermalOutputs> outputs_c{};  ///< of a part that the mesh lacks: the ambient
  ThermalCoefficients coefficients{};
  double air_c{};  ///< mean of block and shell, at which the air's conductivity was taken
  double power_in_w{};
  double power_out_w{};           ///< through the film
  ExtremePoint hottest, coldest;  ///< of all solids: neither gas nor air
  ExtremePoint block_hottest, block_coldest;
  int rounds{};      ///< of the air's temperature
  int iterations{};  ///< of the linear solver, all rounds together
  std::size_t unknowns{};
};

/// Fails with numeric if a linear solve or the rounds do not converge.
[[nodiscard]] Result<SteadyState> steady_state(const GyroModel& model, const GyroMesh& mesh,
                                               const SteadyOptions& options = {});

/// Mean of A, B, C less mean of F, G, H: what the paper gives as 3.5 K.
[[nodiscard]] double gain_difference_k(std::span<const double, kThermalOutputs> outputs_c);

/// Temperature that the gaps' air takes from the outputs: the mean of block and shell.
[[nodiscard]] double air_temperature_c(std::span<const double, kThermalOutputs> outputs_c);

}  // namespace gyrotherm::thermal
