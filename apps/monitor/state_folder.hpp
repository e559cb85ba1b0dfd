// SPDX-License-Identifier: Apache-2.0
/// The monitor's state folder and its private files: users, sessions, and the memory of notifications. Only the user of
/// the monitor may read them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr const char *kUsersFile = "users.json", *kSessionsFile = "sessions.json",
                            *kNotificationsFile = "told.json";

/// Returns `given` unless it is empty; otherwise $STATE_DIRECTORY of systemd, or a folder in $XDG_STATE_HOME or
/// ~/.local/state.
[[nodiscard]] std::string resolve_state_folder(const std::string& given);
/// Creates the folder with mode 0700 if it does not exist. Fails with storage.
[[nodiscard]] Result<void> make_state_folder(const std::string& folder);

/// Reads a whole file. Returns nothing if it does not exist. Fails with bad_file if it cannot be read, is a link,
/// belongs to a user other than this one and root, or is accessible to other users.
[[nodiscard]] Result<std::optional<std::string>> read_private_file(const std::string& path);
/// Replaces a file atomically, with mode 0600. Its folder must exist. Fails with storage.
[[nodiscard]] Result<void> write_private_file(const std::string& path, std::string_view text);

}  // namespace gyrotherm::monitor
