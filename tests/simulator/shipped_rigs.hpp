// SPDX-License-Identifier: Apache-2.0
/// The shipped virtual rigs and the rate cycles of the qualification, for the tests of the simulator.
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

/// Returns the path, the text and the laboratory of profiles/rigs/NAME.toml.
[[nodiscard]] std::string rig_path(const std::string& name);
[[nodiscard]] std::string rig_text(const std::string& name);
[[nodiscard]] LaboratoryParameters laboratory_of_rig(const std::string& name);
/// Returns the gyro of such a rig.
[[nodiscard]] LumpedGyroParameters lumped_of_rig(const std::string& name);
[[nodiscard]] ReducedGyroParameters reduced_of_rig(const std::string& name);
[[nodiscard]] drivers::FrameFormat gyro_of_rig(const std::string& name);
/// Returns the gyro lines of a rig with [[gyro]].
[[nodiscard]] std::vector<VirtualGyroLine> gyro_lines_of_rig(const std::string& name);
/// Returns the thermometers of a rig that uses only Lake Shore 218.
[[nodiscard]] std::vector<VirtualThermometer> thermometers_of_rig(const std::string& name);
/// Returns profiles/chambers/NAME.toml.
[[nodiscard]] drivers::RegisterMap chamber_map(const std::string& name);
/// Returns the names of all shipped chambers in alphabetical order.
[[nodiscard]] std::vector<std::string> shipped_chambers();

/// Returns the set points of one rate cycle, one per second: 20 °C, then −40, 60, −40, 60, 20 °C, each held for 2 h.
[[nodiscard]] std::vector<double> rate_cycle_c(double rate_c_per_min);
/// Returns the set points of the reference simulation's random profile, 144,000 s.
[[nodiscard]] std::vector<double> random_profile_c();

}  // namespace gyrotherm::simulator
