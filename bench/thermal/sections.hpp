/// The sections of the thermal benchmark; each prints its figures.
#pragma once

#include <string>

#include "core/result.hpp"
#include "thermal/gyro_model.hpp"
#include "thermal/mesh.hpp"

namespace gyrotherm {

struct ThermalBench {
  std::string gyro;     ///< the gyro file
  std::string reduced;  ///< its reduced model
  std::string scratch = ".";
  MeshSize mesh = MeshSize::medium;
};

/// One linear steady state: time, memory, energy balance, gain–non-gain difference. A process of its own, for its
/// memory.
Result<void> measure_steady(const ThermalBench& bench);
/// The same beside CalculiX's iterative solver; with `direct`, its direct one too.
Result<void> measure_beside_calculix(const ThermalBench& bench, bool direct);
/// What a finer mesh changes: from medium to fine, or to medium from coarse where `bench.mesh` is coarse.
Result<void> measure_mesh_step(const ThermalBench& bench);
/// The reduced twin over the whole programme of 61.56 h.
Result<void> measure_reduced(const ThermalBench& bench);

[[nodiscard]] Result<GyroModel> read_gyro(const ThermalBench& bench);

}  // namespace gyrotherm
