// SPDX-License-Identifier: Apache-2.0
/// How a program that drives a real chamber is watched: the safe-state file beside the record, a guard in a process of
/// its own, and systemd's watchdog where there is one. Whatever of it goes missing is told, and put back.
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
  /// Opens the socket that the environment names (NOTIFY_SOCKET); nothing where systemd did not start this program.
  [[nodiscard]] static std::optional<NotifySocket> from_environment();
  /// At `address`: a path, or "@NAME" for an abstract one. Nothing if it is too long.
  [[nodiscard]] static std::optional<NotifySocket> at(std::string address);

  /// "READY=1", "WATCHDOG=1", "STATUS=…", "STOPPING=1". Never blocks; what cannot be told is not told.
  void notify(std::string_view state);

 private:
  NotifySocket(Descriptor socket, std::string address) : socket_(std::move(socket)), address_(std::move(address)) {}
  Descriptor socket_;
  std::string address_;
};

/// Calls come from the thread that ticks. Only tie() waits, some seconds, and good_bye(), one at most: two threads of
/// its own start programs and look after files.
class WatchdogClient {
 public:
  /// Writes the safe-state file, starts the guard and waits until it watches. Fails with storage, or with bad_file if
  /// no guard can be started; then there is the safe-state file that was there before, or none.
  [[nodiscard]] static Result<std::unique_ptr<WatchdogClient>> tie(const SafeState& safe_state);
  /// Without a good-bye the guard takes the end of the process for a death.
  ~WatchdogClient();
  WatchdogClient(const WatchdogClient&) = delete;
  WatchdogClient& operator=(const WatchdogClient&) = delete;

  /// A tick is done. Silence is a hang.
  void heartbeat();
  /// The run has ended in order: nobody need make anything safe.
  void good_bye();
  /// There was a safe-state file: a program had died, and its chamber has not been made safe.
  [[nodiscard]] bool took_over() const { return took_over_; }
  /// Returns why the chamber would not be made safe if this program died now: of the "guard", of the "safe-state file",
  /// of both, or nothing.
  [[nodiscard]] std::map<std::string, std::string> troubles() const;

 private:
  struct Ties;
  explicit WatchdogClient(std::shared_ptr<Ties> ties) : ties_(std::move(ties)) {}
  void end_threads();

  std::shared_ptr<Ties> ties_;  ///< shared with the threads, of which one may outlast this while a disk hangs
  std::optional<NotifySocket> systemd_;
  std::optional<std::string> watchdog_limit_;  ///< how long systemd lets this program be silent
  bool beating_ = false, took_over_ = false;
  std::thread guard_tender_, file_tender_;
};

}  // namespace gyrotherm::watchdog
