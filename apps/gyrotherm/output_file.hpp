// SPDX-License-Identifier: Apache-2.0
/// Checks of the path of an output file. A command never overwrites a record.
#pragma once

#include <string>

#include "apps/console/command.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Adds the flag --force, which allows a command to overwrite an existing file.
void add_force_flag(CLI::App& command, bool& force);

/// Fails with usage if the folder of the file does not exist, or if `path` is a folder; with storage if the folder is
/// not writable.
[[nodiscard]] Result<void> check_can_create(const std::string& path);

/// Fails with usage unless a path of --out ends in .toml, as `content` does, such as "a map".
[[nodiscard]] Result<void> check_is_toml(const std::string& path, const char* content);

/// Fails like check_can_create(), or with usage if the file exists and `force` is not set. Fails regardless of `force`
/// if the file belongs to a record: an SQLite file such as a record, a part or a live copy, a file next to a record, or
/// the name of a run. Fails with bad_file if the check itself fails.
[[nodiscard]] Result<void> check_is_free(const std::string& path, bool force);

}  // namespace gyrotherm::app
