/// Draws one gyro of a type: the same network and the same bias law with other numbers.
#pragma once

#include <cstdint>

#include "simulator/world_parameters.hpp"

namespace gyrotherm {

/// Seed 0 is the gyro of the file exactly. Any other seed multiplies every heat capacity, film and bias coefficient by
/// a log-normal factor of its own, and adds a calibration error to every thermometer and a turn-on offset to the gyro.
[[nodiscard]] WorldParameters draw_gyro(WorldParameters type, std::uint64_t seed);

}  // namespace gyrotherm
