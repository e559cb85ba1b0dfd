// SPDX-License-Identifier: Apache-2.0
/// The monitor's state folder and its private files: users, sessions, and sent messages. Only the monitor's user may
/// read them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr const char *kUsersFile = "users.json", *kSessionsFile = "sessions.json",
                            *kNotificationsFile = "told.json";

/// Returns the given folder. If it is empty, returns the folder provided by systemd, or otherwise one below the user's
/// home.
[[nodiscard]] std::string resolve_state_folder(const std::string& given);
/// Creates the folder with mode 0700 if it does not exist. Fails with storage.
[[nodiscard]] Result<void> make_state_folder(const std::string& folder);

/// Reads a whole file, or returns nothing if it does not exist. Fails with bad_file, also if it is a link, belongs to
/// another user, or is accessible to others.
[[nodiscard]] Result<std::optional<std::string>> read_private_file(const std::string& path);
/// Replaces a file atomically, mode 0600. Its folder must exist. Fails with storage.
[[nodiscard]] Result<void> write_private_file(const std::string& path, std::string_view text);

}  // namespace gyrotherm::monitor
