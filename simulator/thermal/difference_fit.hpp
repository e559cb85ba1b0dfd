// SPDX-License-Identifier: Apache-2.0
/// Finds the value of a parameter for which the temperature difference between gain and non-gain areas has a required
/// value. This is a calibration: several parameters can be adjusted to the same observation, and the observation does
/// not show which of them is right.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "simulator/thermal/gyro_model.hpp"

namespace gyrotherm::thermal {

/// A parameter to fit: effective emissivity of all gaps, Nusselt number of all gaps, the block's thickness, the dither
/// zone's conductivity, or the film (on the cabinet in still air, or on the block in block mode).
enum class FitParameter { emissivity, nusselt, thickness, dither, film };
inline constexpr std::array<std::string_view, 5> kFitParameterNames{"emissivity", "nusselt", "thickness_mm",
                                                                    "dither_w_per_m_k", "film_w_per_m2_k"};

/// Returns the model with another value of one parameter.
[[nodiscard]] GyroModel replace_parameter(const GyroModel& model, FitParameter parameter, double value);

struct FitRange {
  double low{}, high{};
};
/// Returns the range to search: plausible values that the model's geometry permits. If it permits no thickness, both
/// ends are the present one.
[[nodiscard]] FitRange fit_range(const GyroModel& model, FitParameter parameter);

struct FitOptions {
  /// Edge length of the mesh.
  double edge_mm = 4.6;
  double ambient_c = 20;
  /// Tolerance of the difference.
  double tolerance_k = 0.002;
  int most_steps = 25;
};

struct FittedDifference {
  FitParameter parameter{};
  /// Fitted value. If the difference was not reached, the nearer end of the range.
  double value{};
  /// Temperature difference that the model has with the fitted value.
  double difference_k{};
  bool reached = false;
  /// Temperature of the warmest location of A…H. The difference does not determine this level.
  double warmest_location_c{};
  /// Number of computed steady states.
  int steps{};
};

/// Fits one parameter by bisection accelerated by secants (Illinois method). All other parameters keep their values.
/// Fails like steady_state(), or with interrupted. If no value of the range yields the difference, the result has
/// reached = false.
[[nodiscard]] Result<FittedDifference> fit_difference(const GyroModel& model, FitParameter parameter, double wanted_k,
                                                      const FitOptions& options = {},
                                                      const ProgressSink& progress = {});

/// Fits separately each parameter that has an effect in the model's mode. The results are alternatives that fit equally
/// well.
[[nodiscard]] Result<std::vector<FittedDifference>> fit_family(const GyroModel& model, double wanted_k,
                                                               const FitOptions& options = {},
                                                               const ProgressSink& progress = {});

}  // namespace gyrotherm::thermal
