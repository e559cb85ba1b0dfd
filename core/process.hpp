// SPDX-License-Identifier: Apache-2.0
/// The process that runs, and its neighbours on the machine: its signals, its end by a broken law, the programs that
/// were installed with it, and the users who own other processes.
#pragma once

#include <csignal>
#include <cstdint>
#include <string>

namespace gyrotherm {

/// Keeps every signal away from the calling thread from now on. Each thread beside the main one calls this first: a
/// signal belongs to the main thread, and would end a poll of the instruments' libraries as an unplugged device does.
inline void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

/// Ends the process with SIGABRT if `holds` is false, and names the law on stderr; this is so in every build. A program
/// that breaks a law of safety must not go on commanding: what watches over the process makes the chamber safe.
void ensure(bool holds, const char* law);

/// The path of the program `name` that was installed beside the one that runs; it need not be there.
[[nodiscard]] std::string program_beside_this_one(const std::string& name);

/// Whether this user may run the file, and it is a regular one.
[[nodiscard]] bool may_run(const std::string& path);
/// The program of that name in the first folder of PATH, or of /usr/bin and /bin where there is none, that has one
/// which this user may run; folders that are relative are so to `folder`. Empty: there is no such program.
[[nodiscard]] std::string program_in_path(const std::string& name, const std::string& folder = ".");

/// The name of a user of this machine, or "unknown" where /etc/passwd has no such user. Directory services are not
/// asked: one that does not answer would hold whoever drives a chamber.
[[nodiscard]] std::string user_name(std::int64_t uid);
/// Name and number of a user: "ada (uid 1000)", "unknown (uid 1000)".
[[nodiscard]] std::string user_in_words(std::int64_t uid);

}  // namespace gyrotherm
