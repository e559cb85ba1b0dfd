/// A gyro of 384 cells that takes milliseconds: a block with a warm side in a cabinet, air between them.
#pragma once

#include "thermal/model_order_reduction.hpp"
#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm {

/// Finite volumes of 18 mm; alike left and right; the heat capacity has small numbers beside its diagonal.
[[nodiscard]] ThermalSystem box_gyro();

/// Names, air, films and powers of the box gyro; no matrices.
[[nodiscard]] ReducedModel about_box_gyro();

/// By factorisation.
[[nodiscard]] SolveColumns direct_solver();

/// box_gyro reduced to the goal of 1e-4 K, made once.
[[nodiscard]] const ReducedSystem& reduced_box_system();
[[nodiscard]] const ReducedModel& reduced_box_gyro();

}  // namespace gyrotherm
