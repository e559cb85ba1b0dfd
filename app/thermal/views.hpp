// SPDX-License-Identifier: Apache-2.0
/// The thermal image of a steady state, as views through the gyro.
#pragma once

#include <string>
#include <vector>

#include "thermal/gyro_model.hpp"
#include "thermal/mesh.hpp"
#include "thermal/steady_state.hpp"
#include "thermal/thermal_image.hpp"

namespace gyrotherm::app {

struct ThermalView {
  std::string file;  ///< without its suffix: "top-face"
  thermal::ThermalImage image;
};

/// The block's top face with the thermometers, the plane of the bores, and the upright section from G to A. The block
/// and what is on it are coloured, on one scale in all views; air is white, and the cabinet with what stands on it
/// shows as outlines.
[[nodiscard]] std::vector<ThermalView> thermal_views(const thermal::GyroModel& model, const thermal::GyroMesh& mesh,
                                                     const thermal::SteadyState& state);

}  // namespace gyrotherm::app
