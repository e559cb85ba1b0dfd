// SPDX-License-Identifier: Apache-2.0
/// Subcommands of `gyrotherm report`, each in a file of its own.
#pragma once

#include "app/command.hpp"

namespace gyrotherm::app {

void add_report_compare(Program& program, CLI::App& report);
/// `authorise` and `supersede`.
void add_report_state(Program& program, CLI::App& report);
void add_report_sign(Program& program, CLI::App& report);
void add_report_verify(Program& program, CLI::App& report);

}  // namespace gyrotherm::app
