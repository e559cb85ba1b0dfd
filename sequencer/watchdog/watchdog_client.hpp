// SPDX-License-Identifier: Apache-2.0
/// The watchdog of a program that drives a real chamber: the safe-state file next to the record, a guard in a separate
/// process, and systemd's watchdog if there is one. A missing file or guard is reported and replaced.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "core/file.hpp"
#include "core/result.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::watchdog {

class NotifySocket {
 public:
  /// Opens the socket that the environment names (NOTIFY_SOCKET). Returns nothing if systemd did not start this
  /// program.
  [[nodiscard]] static std::optional<NotifySocket> from_environment();
  /// Opens the socket at `address`: a path, or "@NAME" for an abstract one. Returns nothing if it is too long.
  [[nodiscard]] static std::optional<NotifySocket> at(std::string address);

  /// Sends "READY=1", "WATCHDOG=1", "STATUS=…" or "STOPPING=1". Never blocks; drops a message that the socket cannot
  /// accept.
  void notify(std::string_view state);

 private:
  NotifySocket(Descriptor socket, std::string address) : socket_(std::move(socket)), address_(std::move(address)) {}
  Descriptor socket_;
  std::string address_;
};

/// Use it from the thread that ticks. start() waits for some seconds, and end_watch() for one second at most. No other
/// function waits: two internal threads start programs and check files.
class WatchdogClient {
 public:
  /// Writes the safe-state file, starts the guard and waits until it watches. Fails with storage, or with bad_file if
  /// no guard can be started; then the previous safe-state file is restored, or removed if there was none.
  /// `place` is the name of the chamber's lock, whose waiting guards are relieved; empty: none is.
  [[nodiscard]] static Result<std::unique_ptr<WatchdogClient>> start(const SafeState& safe_state,
                                                                     const std::string& place = {});
  /// Ends the threads. If the process ends without end_watch(), the guard treats that as a failure.
  ~WatchdogClient();
  WatchdogClient(const WatchdogClient&) = delete;
  WatchdogClient& operator=(const WatchdogClient&) = delete;

  /// Reports that a tick is done. The guard treats silence as a hang. The first heartbeat shows that this program
  /// drives the chamber; from then on, the guards of dead runs that wait for the chamber are relieved while the own
  /// guard watches. Before it, a failed start may still leave the chamber to them.
  void heartbeat();
  /// Reports that the run has ended in order, so the guard does not act. If there were heartbeats, relieves the waiting
  /// guards first, because their runs no longer own the chamber. Call it before the chamber's lock is released.
  void end_watch();
  /// Returns true if start() found a safe-state file: a program had died, and its chamber was not made safe.
  [[nodiscard]] bool took_over() const { return took_over_; }
  /// Returns the reasons why the watchdog could not make the chamber safe if this program died now: for "guard", for
  /// "safe-state file", for both, or none.
  [[nodiscard]] std::map<std::string, std::string> troubles() const;

 private:
  struct SharedState;
  explicit WatchdogClient(std::shared_ptr<SharedState> shared) : shared_(std::move(shared)) {}
  void end_threads();

  /// Shared with the threads. One of them may outlive this object while a disk hangs.
  std::shared_ptr<SharedState> shared_;
  std::optional<NotifySocket> systemd_;
  std::optional<std::string> watchdog_limit_;  ///< systemd's limit of silence
  bool beating_ = false, took_over_ = false;
  std::thread guard_thread_, file_thread_;
};

}  // namespace gyrotherm::watchdog
