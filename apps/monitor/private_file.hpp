// SPDX-License-Identifier: Apache-2.0
/// Files that only the monitor's own user may read: users, sessions, what was told.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::monitor {

/// Reads all of it; nothing where there is none. Fails with bad_file, also if it is a link, another's, or open to
/// others.
[[nodiscard]] Result<std::optional<std::string>> read_private_file(const std::string& path);

/// Replaces it as a whole, mode 0600, in a folder that must be there. Fails with storage.
[[nodiscard]] Result<void> write_private_file(const std::string& path, std::string_view text);

}  // namespace gyrotherm::monitor
