// SPDX-License-Identifier: Apache-2.0
/// The file that a command writes: where it may, and what it never writes over.
#pragma once

#include <string>

#include "apps/console/command.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// The flag --force of a command that writes a file which somebody may want to keep.
void add_force_flag(CLI::App& command, bool& force);

/// Fails with usage where the folder that it would lie in is not there, or where it is one itself.
[[nodiscard]] Result<void> check_can_be_made(const std::string& path);

/// Fails also where `path` is there already and is not to be written over; and, whatever `force` says, where it is of a
/// record: an SQLite file, as records, their parts and live copies are, what stands beside one, or a name that a run
/// has. Fails with bad_file if that cannot be told.
[[nodiscard]] Result<void> check_is_free(const std::string& path, bool force);

}  // namespace gyrotherm::app
