// SPDX-License-Identifier: Apache-2.0
/// The subcommands of gyrotherm-thermal.
#pragma once

#include "app/command.hpp"

namespace gyrotherm::app {

void add_thermal_fit(Program& program);
void add_thermal_image(Program& program);
void add_thermal_reduce(Program& program);

}  // namespace gyrotherm::app
