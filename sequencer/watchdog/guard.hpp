// SPDX-License-Identifier: Apache-2.0
/// A process that can be told from a later one with the same number.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::watchdog {

struct ProcessIdentity {
  std::int64_t pid{};
  std::uint64_t started{};  ///< ticks since the machine started, of the kernel's own clock
  std::string boot;         ///< id of the machine's start
  bool operator==(const ProcessIdentity&) const = default;
};

/// Returns nothing if there is no such process, or it has ended and only waits to be reaped.
[[nodiscard]] std::optional<ProcessIdentity> identity_of(std::int64_t pid);
[[nodiscard]] ProcessIdentity own_identity();
[[nodiscard]] bool lives(const ProcessIdentity& process);

/// Whether it stands still: stopped, by Ctrl-Z or a debugger.
[[nodiscard]] bool is_stopped(std::int64_t pid);

/// Waits at most `within` for the end of that process and all of its threads; false if there are some then.
[[nodiscard]] bool ends(const ProcessIdentity& process, Duration within);

/// Sends SIGKILL to that process and to no other, and waits as ends() does.
[[nodiscard]] bool kill_surely(const ProcessIdentity& process, Duration within);

// The line between the program that drives a chamber and its guard: the program sends what the guard needs to make the
// chamber safe, then a byte a tick; the guard says that it watches, and answers each byte.

/// What the program sends. Any other byte counts as kAlive.
inline constexpr char kSafeStateFollows =
    'A';                                 ///< then a length in digits, a line break, and the text of a safe-state file
inline constexpr char kPreparing = 'p';  ///< alive, and the next byte may take long
inline constexpr char kAlive = '.';      ///< a tick is done; the next byte is due in a second
inline constexpr char kGoodBye = 'q';    ///< ended in order; nothing is to be done

/// What the guard sends.
inline constexpr char kWatching = 'w';  ///< it has understood the safe-state file's text, and listens from now on
inline constexpr char kHeard = 'h';     ///< it has heard something: no silence begins before this

/// The bytes that give a guard the text of a safe-state file.
[[nodiscard]] std::string safe_state_message(std::string_view safe_state_text);
/// The text of the safe-state file, from a line that begins with it. Fails with timeout, disconnected or corrupted;
/// nothing after it is taken.
[[nodiscard]] Result<std::string> receive_safe_state(int descriptor, Duration within);

enum class WatchEnd { good_bye, closed, silent };

struct WatchLimits {
  Duration silence = std::chrono::seconds(8);
  Duration preparing = std::chrono::minutes(15);  ///< an upload of a long program
};

/// Reads from the descriptor until the watch has an end, and answers what it hears where the descriptor is a socket.
/// Silence is counted in slices of a second: a machine that stood still does not make a program late.
[[nodiscard]] WatchEnd watch(int descriptor, const WatchLimits& limits = {});

}  // namespace gyrotherm::watchdog
