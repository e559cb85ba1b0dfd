// SPDX-License-Identifier: Apache-2.0
/// Exclusive control of a real chamber: the lock of the chamber, and the watchdog. A virtual rig needs neither.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/chamber_lock.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/watchdog/guard_post.hpp"
#include "sequencer/watchdog/watchdog_client.hpp"

namespace gyrotherm::run {

class ChamberOwnership {
 public:
  /// Takes the chamber's lock. `by_program` is true if the controller will carry out the profile. Fails with refused if
  /// another program drives the chamber.
  [[nodiscard]] static Result<ChamberOwnership> take(const rig::RigFile& rig, const std::string& record,
                                                     bool by_program = false);

  /// Returns the guards of dead runs that waited for the chamber when its lock was taken. They end once this program
  /// has armed its own watchdog and has sent a heartbeat.
  [[nodiscard]] const std::vector<watchdog::WaitingGuard>& waiting_guards() const { return waiting_guards_; }

  /// Describes the processes that hold the chamber's lock without permission to drive chambers. take() ignores such
  /// locks.
  [[nodiscard]] std::vector<std::string> unauthorised_holders() const;

  /// Arms the watchdog: from now on it makes the chamber safe if this program dies or hangs. Call it immediately before
  /// the chamber is first moved. `identity` is the identity that the chamber reported; the watchdog does not make
  /// another chamber safe. `settings` contains the controller's settings as last read. Fails like
  /// WatchdogClient::start().
  [[nodiscard]] Result<void> arm(const std::string& identity, const drivers::ControllerSettings& settings = {});
  [[nodiscard]] bool is_armed() const { return watchdog_ != nullptr; }
  /// Sends a heartbeat at the end of a tick. The first one begins to relieve the guards of dead runs. `stuck` is the
  /// time for which the current call to the chamber has made no progress. If it exceeds a limit, no heartbeat is sent.
  void heartbeat(Duration stuck);
  /// Returns, by subject, the reasons why the watchdog could not make the chamber safe. Empty if it could, or if it is
  /// not armed.
  [[nodiscard]] std::map<std::string, std::string> troubles() const {
    return watchdog_ ? watchdog_->troubles() : std::map<std::string, std::string>();
  }
  /// Returns true if a program died and left this chamber, and it has not been made safe since.
  [[nodiscard]] bool took_over() const { return watchdog_ && watchdog_->took_over(); }
  /// Leaves the chamber unchanged. If the program ends without this call, the watchdog makes the chamber safe.
  void release();

 private:
  /// Absent for a virtual rig.
  std::optional<watchdog::SafeState> safe_state_;
  std::string place_{};  ///< name of the lock
  std::optional<drivers::ChamberLock> lock_;
  std::unique_ptr<watchdog::WatchdogClient> watchdog_;
  std::vector<watchdog::WaitingGuard> waiting_guards_;
};

/// Returns the name of the lock for a real rig's chamber.
[[nodiscard]] std::string chamber_lock_name(const rig::RigFile& rig);

}  // namespace gyrotherm::run
