/// A process that can be told from a later one with the same number.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

#include "core/quantity.hpp"

namespace gyrotherm {

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

}  // namespace gyrotherm
