// SPDX-License-Identifier: Apache-2.0
/// The identity of a process, and the protocol between a program and its guard.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::watchdog {

/// Identifies a process. A later process with the same number has another identity.
struct ProcessIdentity {
  std::int64_t pid{};
  /// Start of the process in ticks of the kernel's clock since the start of the machine.
  std::uint64_t started{};
  std::string boot;  ///< id of the machine's start
  bool operator==(const ProcessIdentity&) const = default;
};

/// Returns nothing if there is no such process, or if it has ended and only waits to be reaped.
[[nodiscard]] std::optional<ProcessIdentity> read_process_identity(std::int64_t pid);
[[nodiscard]] ProcessIdentity own_identity();
[[nodiscard]] bool is_alive(const ProcessIdentity& process);

/// Returns true if the process is stopped, by Ctrl-Z or a debugger.
[[nodiscard]] bool is_stopped(std::int64_t pid);

/// Waits at most `within` for the end of a process and all of its threads. Returns false if some remain.
[[nodiscard]] bool wait_for_end(const ProcessIdentity& process, Duration within);

/// Sends SIGKILL to exactly this process, and waits as wait_for_end() does.
[[nodiscard]] bool kill_process(const ProcessIdentity& process, Duration within);

// The connection between the program that drives a chamber and its guard. The program sends the safe-state file, which
// the guard needs to make the chamber safe, then one byte per tick. The guard confirms that it is watching, and answers
// each byte.

/// Bytes of the program. Any other byte counts as kAlive.
inline constexpr char kSafeStateFollows = 'A';
/// The program is alive, but its next byte may arrive late.
inline constexpr char kPreparing = 'p';
/// A tick is done; the next byte is due in a second.
inline constexpr char kAlive = '.';
/// The program ends in order; the guard need not act.
inline constexpr char kGoodBye = 'q';

/// Bytes of the guard.
inline constexpr char kWatching = 'w';
/// The guard has received a byte, and measures silence from then on.
inline constexpr char kHeard = 'h';

/// Returns the bytes that send the text of a safe-state file to a guard.
[[nodiscard]] std::string safe_state_message(std::string_view safe_state_text);
/// Receives the text of the safe-state file from a line that begins with it, and nothing after it. Fails with timeout,
/// disconnected or corrupted.
[[nodiscard]] Result<std::string> receive_safe_state(int descriptor, Duration within);

enum class WatchEnd { good_bye, closed, silent };

struct WatchLimits {
  Duration silence = std::chrono::seconds(8);
  Duration preparing = std::chrono::minutes(15);  ///< upload of a long program
};

/// Reads from the descriptor until the watch ends, and answers each byte if the descriptor is a socket. Counts silence
/// in slices of one second, so a sleep of the machine does not look like a late program.
[[nodiscard]] WatchEnd watch(int descriptor, const WatchLimits& limits = {});

}  // namespace gyrotherm::watchdog
