// SPDX-License-Identifier: Apache-2.0
/// Subcommands of `gyrotherm report`, each in a file of its own.
#pragma once

#include <string>
#include <vector>

#include "apps/console/command.hpp"

namespace gyrotherm::app {

/// The option --language.
void add_languages(CLI::App& command, std::vector<std::string>& languages);

void add_report_compare(Program& program, CLI::App& report);
/// `authorise` and `supersede`.
void add_report_state(Program& program, CLI::App& report);
void add_report_sign(Program& program, CLI::App& report);
void add_report_verify(Program& program, CLI::App& report);

}  // namespace gyrotherm::app
