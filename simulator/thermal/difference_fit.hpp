// SPDX-License-Identifier: Apache-2.0
/// Which value of a parameter gives a wanted difference between gain and non-gain areas. That is calibration: one
/// number meets a whole family of parameters, and says nothing of which member is true.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "simulator/thermal/gyro_model.hpp"

namespace gyrotherm::thermal {

/// Of all gaps alike: effective emissivity, Nusselt number; the block's thickness; the dither zone's conductivity; the
/// film, on the cabinet in still air or on the block that stands alone.
enum class FitParameter { emissivity, nusselt, thickness, dither, film };
inline constexpr std::array<std::string_view, 5> kFitParameterNames{"emissivity", "nusselt", "thickness_mm",
                                                                    "dither_w_per_m_k", "film_w_per_m2_k"};

/// The model with another value of one parameter.
[[nodiscard]] GyroModel with_parameter(const GyroModel& model, FitParameter parameter, double value);

struct FitRange {
  double low{}, high{};
};
/// Values that are searched: what is plausible, and what the model's geometry bears.
[[nodiscard]] FitRange fit_range(const GyroModel& model, FitParameter parameter);

struct FitOptions {
  double edge_mm = 4.6;  ///< of the mesh
  double ambient_c = 20;
  double tolerance_k = 0.002;  ///< of the difference
  int most_steps = 25;
};

struct FittedDifference {
  FitParameter parameter{};
  double value{};         ///< that gives it, or the end of the range that comes nearest
  double difference_k{};  ///< with that value
  bool reached = false;
  double warmest_place_c{};  ///< of A…H: the level, which the difference leaves open
  int steps{};               ///< steady states computed
};

/// By bisection sped up by secants (Illinois); everything else stays as in the model. Fails as steady_state() does, or
/// with interrupted. A difference that no value of the range gives is a result: reached is false.
[[nodiscard]] Result<FittedDifference> fit_difference(const GyroModel& model, FitParameter parameter, double wanted_k,
                                                      const FitOptions& options = {},
                                                      const ProgressSink& progress = {});

/// The same for every parameter that plays a part in the model's mode: what else fits as well.
[[nodiscard]] Result<std::vector<FittedDifference>> fit_family(const GyroModel& model, double wanted_k,
                                                               const FitOptions& options = {},
                                                               const ProgressSink& progress = {});

}  // namespace gyrotherm::thermal
