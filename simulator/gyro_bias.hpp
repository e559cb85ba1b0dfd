/// The gyro's bias as a function of its temperatures alone.
#pragma once

#include "core/quantity.hpp"
#include "simulator/gyro_thermal.hpp"
#include "simulator/world_parameters.hpp"

namespace gyrotherm {

/// The mean of A…H.
[[nodiscard]] double block_mean_c(BlockTemperatures block_c);

/// b = s·{ k1·x + k2·x² + Σ_{X=B…H} g_X (T_A − T_X) + arm·(T_B + T_D − T_C − T_E)/2·(1 + growth·x) + u·sin(2πx/period)
/// }, x = block mean − 20 °C. The reference simulation's law: a temperature part no gradient can see (k1, k2, u), a
/// part linear in the gradients, and the unequal gas flow of the two discharge arms, which grows with temperature.
[[nodiscard]] DegreesPerHour thermal_bias(const BiasParameters& bias, BlockTemperatures block_c);

}  // namespace gyrotherm
