// SPDX-License-Identifier: Apache-2.0
/// Shipped virtual rigs and ramp cycles of the qualification, for tests of the simulator.
#pragma once

#include <string>
#include <vector>

#include "drivers/chamber/register_map.hpp"
#include "drivers/gyro/frame_format.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_gyro_line.hpp"
#include "simulator/virtual_instruments.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Return the path, the text and the laboratory of profiles/rigs/NAME.toml.
[[nodiscard]] std::string rig_path(const std::string& name);
[[nodiscard]] std::string rig_text(const std::string& name);
[[nodiscard]] LaboratoryParameters laboratory_of_rig(const std::string& name);
/// Return the lumped gyro, the reduced gyro and the frame format of a shipped rig.
[[nodiscard]] LumpedGyroParameters lumped_of_rig(const std::string& name);
[[nodiscard]] ReducedGyroParameters reduced_of_rig(const std::string& name);
[[nodiscard]] drivers::FrameFormat gyro_of_rig(const std::string& name);
/// Returns the gyro lines of a rig with [[gyro]].
[[nodiscard]] std::vector<VirtualGyroLine> gyro_lines_of_rig(const std::string& name);
/// Returns the thermometers of a rig. The rig must use only Lake Shore 218 instruments.
[[nodiscard]] std::vector<VirtualThermometer> thermometers_of_rig(const std::string& name);
/// Returns profiles/chambers/NAME.toml.
[[nodiscard]] drivers::RegisterMap chamber_map(const std::string& name);
/// Returns the names of all shipped chambers in alphabetical order.
[[nodiscard]] std::vector<std::string> shipped_chambers();

/// Returns the set points of one ramp cycle, one per second: holds of two hours at 20, −40, 60, −40, 60 and 20 °C.
[[nodiscard]] std::vector<double> rate_cycle_c(double rate_c_per_min);
/// Returns the set points of the random profile of the reference simulation for its 144,000 s.
[[nodiscard]] std::vector<double> random_profile_c();

}  // namespace gyrotherm::simulator
