/// How far a reduced model is from the full one in time: the two programs of its file's [error].
#pragma once

#include "core/result.hpp"
#include "thermal/model_order_reduction.hpp"

namespace gyrotherm {

struct ReductionTrial {
  GyroFilm film = GyroFilm::chamber;
  double air_c = 20;      ///< coefficients are those of the gaps at this temperature, throughout
  double shortest_s = 5;  ///< step after a corner of the ramps; they grow to 120 s
  bool switch_on = true;  ///< off: only the ramps
};

/// Ramps: the gyro, on, rests at 20 °C; +5 °C/min to 60, 30 min there, −1 °C/min to −40, 20 min there. Switch-on: it
/// rests at 20 °C, off; all powers at once, 1 h. Both models by the trapezoidal rule on the same steps,
/// damped where their length changes, so that what
/// differs is the reduction alone; largest difference over A…H after any step. Sets ramp_k and switch_on_k.
/// Fails with numeric, as `solve` does, or with interrupted.
[[nodiscard]] Result<ReductionError> measure(const ThermalSystem& system, const ReducedSystem& reduced,
                                             const ReductionTrial& trial, const SolveColumns& solve,
                                             const ProgressSink& progress = {});

}  // namespace gyrotherm
