// SPDX-License-Identifier: Apache-2.0
/// Lock of a history of check runs, so that two programs that add to it at once lose nothing.
#pragma once

#include <string>

#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

/// Longest wait for another program. Measuring the records of a year takes less than a minute.
inline constexpr Duration kLockTimeout = std::chrono::minutes(2);

/// Locks the history at `history` until the descriptor is closed or the program ends, however it ends. Waits at most
/// `within` for another program. The lock is an open file description lock of the file HISTORY.lock, which remains. A
/// link is resolved first, so all names of a history have one lock. Fails with storage if the file cannot be created,
/// and with timeout if the other program does not finish.
[[nodiscard]] Result<Descriptor> lock_history(const std::string& history, Duration within = kLockTimeout);

}  // namespace gyrotherm::app
