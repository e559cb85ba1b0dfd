// SPDX-License-Identifier: Apache-2.0
/// What a program takes on when it drives a real chamber: the chamber is its own, and it is watched. On a virtual rig
/// there is nothing to take on.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/chamber_lock.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/watchdog/watchdog_client.hpp"

namespace gyrotherm::run {

class ChamberOwnership {
 public:
  /// Takes the chamber's lock. `by_program`: the controller is to carry the profile out. Fails with refused if another
  /// program drives it.
  [[nodiscard]] static Result<ChamberOwnership> take(const rig::RigFile& rig, const std::string& record,
                                                     bool by_program = false);

  /// Names the processes of users who may not drive chambers that hold the chamber's name, and were passed over.
  [[nodiscard]] std::vector<std::string> strangers() const;

  /// The last thing before the chamber is moved for the first time: from now on somebody else makes it safe if this
  /// program dies or hangs. `identity`: who the chamber reported to be; another one is then not made safe. `settings`:
  /// the controller's own, as last read. Fails like WatchdogClient::tie().
  [[nodiscard]] Result<void> arm(const std::string& identity, const drivers::ControllerSettings& settings = {});
  [[nodiscard]] bool is_armed() const { return watchdog_ != nullptr; }
  /// At the end of a tick. `stuck`: how long the chamber's call that is under way has not got on; past its limit the
  /// watcher hears nothing.
  void heartbeat(Duration stuck);
  /// Returns, by subject, why the chamber would not be made safe; nothing if it would, or there is nothing to guard.
  [[nodiscard]] std::map<std::string, std::string> troubles() const {
    return watchdog_ ? watchdog_->troubles() : std::map<std::string, std::string>();
  }
  /// The chamber is one that a program had left when it died, and nobody has made safe since.
  [[nodiscard]] bool took_over() const { return watchdog_ && watchdog_->took_over(); }
  /// The chamber may be left as it is. A program that ends without this leaves it to the watcher.
  void release();

 private:
  std::optional<watchdog::SafeState> safe_state_;  ///< real rigs have one
  std::optional<drivers::ChamberLock> lock_;
  std::unique_ptr<watchdog::WatchdogClient> watchdog_;
};

/// The place of a real rig's chamber among the locks.
[[nodiscard]] std::string chamber_place(const rig::RigFile& rig);

}  // namespace gyrotherm::run
