/// Draws one gyro of a type: the same body and the same bias law with other numbers.
#pragma once

#include <cstdint>

#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm {

/// Seed 0 is the gyro of the file exactly. Any other seed draws another: each bias coefficient is multiplied by a
/// log-normal factor of its own, and phases are drawn anew; every thermometer gets a calibration error and another time
/// constant, the gyro a constant offset. The reference simulation's heat capacities and films are multiplied likewise,
/// a twin's model is perturbed (twin_spread.hpp).
[[nodiscard]] LaboratoryParameters draw_gyro(LaboratoryParameters type, std::uint64_t seed);

}  // namespace gyrotherm
