// SPDX-License-Identifier: Apache-2.0
/// The post of a process that makes the chamber of a dead run safe, or waits for it: a name in the abstract namespace
/// of Unix sockets. Other programs find the waiting guards of a chamber by it, and a later run reports through it that
/// it has taken the chamber over (docs/decisions/0083). The kernel reports the users at both ends.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/file.hpp"

namespace gyrotherm::watchdog {

class GuardPost {
 public:
  /// Takes a post for the chamber with the lock name `place`. `watched_pid` is the process that has died or hangs; its
  /// reports are ignored. Without a socket the post exists, but receives nothing.
  GuardPost(const std::string& place, std::int64_t watched_pid);

  /// Returns a description of the program that has taken the chamber over, once one has reported it: "process 19233 of
  /// ada (uid 1000), record /data/run.db". Ignores users who may not drive chambers. Waits 0.2 s at most for a report
  /// that has begun.
  [[nodiscard]] std::optional<std::string> find_successor();

 private:
  Descriptor socket_;
  std::int64_t watched_pid_;
  std::optional<std::string> successor_;
};

struct WaitingGuard {
  std::string name;  ///< name of its post
  std::int64_t pid{};
  std::int64_t uid = -1;
  std::string record;  ///< empty: unknown
  /// Text for messages: "process 19233 of ada (uid 1000), which guards the chamber for /data/run.db".
  std::string words;
};

/// Returns the guards of dead runs that make the chamber with the lock name `place` safe, or wait for it. Without a
/// place, returns those of all chambers. Lists only guards of users who may drive chambers.
[[nodiscard]] std::vector<WaitingGuard> find_waiting_guards(const std::string& place = {});

/// Reports to the waiting guards of a chamber that the run with this record has taken it over. Call it only while this
/// process holds the chamber's lock and has a guard of its own that watches. Never waits.
void relieve_guards(const std::string& place, const std::string& record);

}  // namespace gyrotherm::watchdog
