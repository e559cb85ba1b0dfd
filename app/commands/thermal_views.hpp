/// The thermal image of a steady state, as views through the gyro.
#pragma once

#include <string>
#include <vector>

#include "report/thermal_image.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/steady_state.hpp"

namespace gyrotherm {

struct ThermalView {
  std::string file;  ///< without its suffix: "top-face"
  ThermalImage image;
};

/// The block's top face with the thermometers, the plane of the bores, and the upright section from G to A. The block
/// and what is on it are coloured, on one scale in all views; air is white, and the cabinet with what stands on it
/// shows as outlines.
[[nodiscard]] std::vector<ThermalView> thermal_views(const GyroModel& model, const GyroMesh& mesh,
                                                     const SteadyState& state);

}  // namespace gyrotherm
