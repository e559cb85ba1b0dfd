// SPDX-License-Identifier: Apache-2.0
/// Decides whose processes may hold a chamber's lock on this machine. Any process can bind a name of the abstract
/// space; a name counts only if its holder's user may drive chambers here.
#pragma once

#include <cstdint>
#include <optional>

namespace gyrotherm::drivers {

/// The groups whose members may drive chambers: the package's own, and the one that serial ports belong to.
inline constexpr const char* kChamberGroups[] = {"gyrotherm", "dialout"};

/// Returns true for this user, root, and members of one of kChamberGroups by /etc/passwd and /etc/group; directory
/// services are not asked. A user that is not known (below 0) counts as one who may.
[[nodiscard]] bool may_hold_chambers(std::int64_t uid);

/// Returns the user who made the unix socket of that inode in this network namespace, by sock_diag(7); nothing if the
/// kernel does not report it (before Linux 5.3).
[[nodiscard]] std::optional<std::int64_t> user_of_socket(std::uint32_t inode);

}  // namespace gyrotherm::drivers
