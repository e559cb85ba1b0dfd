// SPDX-License-Identifier: Apache-2.0
/// Views of the gyro's temperatures: the field of a steady state, sampled on planes through the cabinet.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "report/plot/thermal_image.hpp"
#include "simulator/thermal/gyro_model.hpp"
#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/steady_state.hpp"

namespace gyrotherm::app {

struct ThermalView {
  std::string file;  ///< name, such as "top-face"
  plot::ThermalImage image;
};

/// Returns three views: the block's top face with the thermometers, the plane of the bores, and the upright section
/// from G to A. The block and its parts are coloured on a scale that all views share. Air is white. The cabinet and its
/// parts are drawn as outlines. `columns` is the number of samples from left to right.
[[nodiscard]] std::vector<ThermalView> make_views(const thermal::GyroModel& model, const thermal::GyroMesh& mesh,
                                                  const thermal::SteadyState& state, std::size_t columns = 900);

/// Returns the block's top face with the thermometers, without the cabinet around it, on its own scale. `columns` is
/// the number of samples from left to right.
[[nodiscard]] plot::ThermalImage make_top_face(const thermal::GyroModel& model, const thermal::GyroMesh& mesh,
                                               const thermal::SteadyState& state, std::size_t columns);

}  // namespace gyrotherm::app
