// SPDX-License-Identifier: Apache-2.0
/// What make-safe leaves beside the record, by processes of its own: the disk may hang, and nothing waits for it.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/deadline.hpp"
#include "sequencer/watchdog/child_work.hpp"
#include "sequencer/watchdog/safe_attempt.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::watchdog {

class Trail {
 public:
  /// `safe_state` outlives it.
  Trail(const SafeState& safe_state, std::string because);

  /// Makes it the trace that `status` shows. False if it says nothing new, or has but another reason why nothing was
  /// confirmed, less than a minute after the last. Never waits.
  bool leave(const Rescued& rescued);
  /// The safe-state file shall go. Never waits.
  void remove_safe_state();
  /// Whether all of it has been done within that time.
  [[nodiscard]] bool settle(Duration within);

  /// Why there is nothing left to do here: the safe-state file is another run's, or gone because somebody else has made
  /// the chamber safe, or for a day. One that is merely gone calls nothing off: it may have been removed with its
  /// record. A disk that does not answer within two seconds gives no reason.
  [[nodiscard]] std::optional<std::string> reason_to_end();

  /// The trace in words.
  [[nodiscard]] std::string describe() const { return watchdog::describe(trace_); }

 private:
  void go_on();
  [[nodiscard]] std::string look_at_orders() const;

  const SafeState& safe_state_;
  MadeSafe trace_;
  Duration began_;  ///< UTC
  std::optional<Deadline> same_until_, gone_until_;
  bool trace_to_write_ = false, to_disarm_ = false;
  std::unique_ptr<ChildWork> writing_;  ///< one at a time, so that the newest trace is the last
  std::unique_ptr<ChildWork> looking_;  ///< one at a time: while the disk hangs none is added
};

}  // namespace gyrotherm::watchdog
