// SPDX-License-Identifier: Apache-2.0
/// Functions for this process and its environment: blocking signals, ending the process on a broken safety invariant,
/// finding installed programs and describing users.
#pragma once

#include <csignal>
#include <cstdint>
#include <string>

namespace gyrotherm {

/// Blocks all signals in the calling thread. Every thread except the main thread, which handles signals, calls this
/// first. In another thread a signal would interrupt poll() in an instrument's library, and the library would report an
/// unplugged device.
inline void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

/// If `holds` is false, prints the invariant to stderr and ends the process with SIGABRT, in every build type. A
/// program with a broken safety invariant must no longer command a chamber; the watchdog then makes the chamber safe.
void ensure(bool holds, const char* invariant);

/// Returns the path of the program `name` in the folder of the running program. The file need not exist.
[[nodiscard]] std::string sibling_program_path(const std::string& name);

/// Returns whether `path` is a regular file that this user may execute.
[[nodiscard]] bool is_executable(const std::string& path);
/// Searches the folders of PATH (/usr/bin and /bin if PATH is not set) for an executable file with this name. Relative
/// folders of PATH are relative to `folder`. Returns the path of the first match, or an empty string.
[[nodiscard]] std::string find_program_in_path(const std::string& name, const std::string& folder = ".");

/// Returns the name of a user of this machine, or "unknown" if /etc/passwd does not list it. Directory services are not
/// queried: one that does not answer would block the process that drives a chamber.
[[nodiscard]] std::string user_name(std::int64_t uid);
/// Returns name and number of a user: "ada (uid 1000)", "unknown (uid 1000)".
[[nodiscard]] std::string describe_user(std::int64_t uid);

}  // namespace gyrotherm
