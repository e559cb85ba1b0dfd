// SPDX-License-Identifier: Apache-2.0
/// Programs that this user has started as drivers from a rig file (`driver = "process"`), with the digests of their
/// files. They are kept in the user's state folder. `run` and `go` store them, `resume` checks them. The record itself
/// is no evidence: its author can write any command into it and compute a new chain.
#pragma once

#include <string>

#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Returns $XDG_STATE_HOME/gyrotherm/confirmed-commands, otherwise $HOME/.local/state/gyrotherm/confirmed-commands, or
/// an empty string if neither variable is set.
[[nodiscard]] std::string confirmed_commands_folder();

/// Returns the text that is stored for a command: rig file, folder and arguments, and the path and digest of the
/// program and of the first argument that names a file. Files below /usr, except /usr/local, belong to packages. They
/// are stored without a digest, because a security update must not prevent a resume.
[[nodiscard]] std::string confirmation_text(const std::string& rig_file, const drivers::ProgramCommand& command);

/// Stores the commands of a rig as confirmed for the rig file at that path. Does nothing for a rig without commands.
/// Fails with storage.
[[nodiscard]] Result<void> confirm_commands(const std::string& rig_file, const rig::RigFile& rig);

/// Fails with refused if a command of the rig differs from the confirmed one of that rig file, or if another user could
/// have written the stored text.
[[nodiscard]] Result<void> check_commands(const std::string& rig_file, const rig::RigFile& rig);

}  // namespace gyrotherm::app
