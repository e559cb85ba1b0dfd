// SPDX-License-Identifier: Apache-2.0
/// Writes the trace of make-safe next to the record. Separate processes write it, so a hanging disk does not block
/// make-safe. A write that fails, for example on a full disk, is repeated every five seconds. The safe-state file and
/// the order to give up are removed only after the trace has been written. No file is changed if the safe-state file
/// belongs to another run; an order to give up that was carried out is removed nevertheless.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/deadline.hpp"
#include "sequencer/watchdog/child_work.hpp"
#include "sequencer/watchdog/safe_attempt.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::watchdog {

/// Longest time that a guard continues without its safe-state file, or waits for the disk after its last action.
inline constexpr Duration kMissingTimeLimit = std::chrono::hours(24);

/// Returns true if the trace states that a later run has taken the chamber over.
[[nodiscard]] bool is_taken_over(const MadeSafe& trace);

class TraceWriter {
 public:
  /// `safe_state` must outlive this object.
  /// `by` is the program that acts; empty: the guard.
  TraceWriter(const SafeState& safe_state, std::string because, std::string by = {});

  /// Writes the result to the trace, which `status` shows. Writes nothing and returns false if the result is unchanged,
  /// or if only the reason for a missing confirmation changed less than a minute after the last trace. Never waits.
  bool record(const RescueResult& rescued);
  /// Writes the state of the relay to the trace. Never waits.
  void note_relay(std::string words);
  /// Writes to the trace that a user has ended the attempts, and removes the order and the safe-state file. Never
  /// waits.
  void note_given_up(std::string who_and_why);
  /// Removes the safe-state file. Never waits.
  void remove_safe_state();
  /// Writes to the trace that a later run has taken the chamber over, and removes the safe-state file. Never waits.
  void hand_over_to(const std::string& successor);
  /// Returns true if everything has been written within that time. Repeats writes that fail.
  [[nodiscard]] bool settle(Duration within);
  /// Returns the error of the latest write, such as "disk full"; empty if the write succeeded or has not returned.
  [[nodiscard]] const std::string& write_fault() const { return write_fault_; }

  /// Returns the order of a user to give up that find_end_reason() has found; empty if there is none.
  [[nodiscard]] const std::string& give_up_order() const { return give_up_order_; }
  /// Returns whether find_end_reason() has found that another program made the chamber safe.
  [[nodiscard]] bool is_fulfilled() const { return is_fulfilled_; }
  /// Returns the reason why make-safe has nothing left to do: a user has ordered it to give up; the safe-state file
  /// belongs to another run; another program has made the chamber safe and removed the file; or the file has been
  /// missing for a day. A file that is merely missing is no reason, because it may have been removed with its record. A
  /// disk that does not answer within two seconds gives no reason.
  [[nodiscard]] std::optional<std::string> find_end_reason();

  /// Describes the trace.
  [[nodiscard]] std::string describe() const { return watchdog::describe(trace_); }

 private:
  void start_pending_work();
  /// Returns true if no work is in progress. After a failure, its parts are pending again.
  bool collect_work(Duration within);
  [[nodiscard]] bool has_pending_work() const { return writing_ || trace_to_write_ || safe_state_to_remove_; }
  [[nodiscard]] std::string carry_out(bool write, bool remove) const;
  [[nodiscard]] std::string read_orders() const;

  const SafeState& safe_state_;
  MadeSafe trace_;
  Duration began_;  ///< UTC
  /// The parts of a result whose change is recorded soon.
  struct Shown {
    SafeStage reached{};
    bool is_ineffective{}, has_shown_commands{};
    bool operator==(const Shown&) const = default;
  };
  Shown shown_;
  /// Times from which a result is recorded that shows the same, or something else.
  std::optional<Deadline> same_until_, changed_until_;
  std::optional<Deadline> gone_until_;
  bool trace_to_write_ = false, safe_state_to_remove_ = false;
  /// The parts of the work in progress.
  bool is_writing_trace_ = false, is_removing_ = false;
  /// Last line of the work in progress.
  std::string work_report_;
  std::string write_fault_;
  /// Time from which a failed write is repeated.
  std::optional<Deadline> retry_from_;
  std::string give_up_order_;
  bool is_fulfilled_ = false;
  /// One at a time, so the newest trace is written last.
  std::unique_ptr<ChildWork> writing_;
  /// One at a time, so a hanging disk does not accumulate processes.
  std::unique_ptr<ChildWork> looking_;
};

}  // namespace gyrotherm::watchdog
