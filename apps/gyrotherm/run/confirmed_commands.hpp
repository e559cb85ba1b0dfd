// SPDX-License-Identifier: Apache-2.0
/// The programs that this user has started as drivers from a rig file (`driver = "process"`), with the digests of their
/// files, in the user's state folder. `run` and `go` write it, `resume` asks it. A record proves nothing of the kind:
/// its author can write any command into it, and chain it anew.
#pragma once

#include <string>

#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Returns $XDG_STATE_HOME/gyrotherm/confirmed-commands, else ~/.local/state/gyrotherm/confirmed-commands by $HOME;
/// empty without either.
[[nodiscard]] std::string confirmed_commands_folder();

/// Returns what is kept of a command: the rig file, the folder, the words, and of the program and of the first other
/// word that names a file the path and digest. Files below /usr but /usr/local belong to packages and have no digest
/// here, so that a security update does not keep a run from being resumed.
[[nodiscard]] std::string confirmation_text(const std::string& rig_file, const drivers::ProgramCommand& command);

/// Keeps the commands of a rig as confirmed, for the rig file of that path. Does nothing on a rig without any. Fails
/// with storage.
[[nodiscard]] Result<void> confirm_commands(const std::string& rig_file, const rig::RigFile& rig);

/// Fails with refused if a command of the rig is not as it was confirmed for the rig file of that path, or if another
/// user could have written what is kept.
[[nodiscard]] Result<void> check_commands(const std::string& rig_file, const rig::RigFile& rig);

}  // namespace gyrotherm::app
