/// Draws one gyro of a type: the reduced model of another specimen, without its finite elements.
#pragma once

#include "core/random.hpp"
#include "thermal/reduced/reduced_model.hpp"

namespace gyrotherm {

/// Sigmas of ln of factors whose median is 1.
struct ThermalSpread {
  double capacity{};  ///< of all heat capacities together
  double gap{};       ///< of each air gap's conductivity, and of its radiation alike
  double film{};      ///< of both films together
  double power{};     ///< of each source: the gain arms together, the preamplifier, the ballasts together
  double arms{};      ///< of the left gain arm's power over the right's, their sum kept; likewise of the ballasts'
};

/// Always takes the same count of numbers from `random`, whatever the spread. Symmetric positive definite stays so;
/// left and right need no longer be alike.
[[nodiscard]] ReducedModel perturbed(const ReducedModel& model, const ThermalSpread& spread, RandomStream& random);

}  // namespace gyrotherm
