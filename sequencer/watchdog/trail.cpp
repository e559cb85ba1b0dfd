// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/trail.hpp"

#include <algorithm>
#include <string_view>
#include <thread>
#include <utility>

#include "core/clock.hpp"
#include "core/deadline.hpp"

namespace gyrotherm::watchdog {
namespace {

constexpr Duration kReadWithin = std::chrono::seconds(2);
constexpr Duration kMinTraceInterval = std::chrono::minutes(1), kMinChangeInterval = std::chrono::seconds(5);
constexpr const char *kActive = "active", *kGone = "gone", *kFulfilled = "fulfilled", *kOtherRun = "another's";
constexpr std::string_view kGiveUp = "give up: ";
constexpr std::string_view kTakenOverWords = " has taken the chamber over and has a guard of its own";
/// Pause before a failed write is repeated.
constexpr Duration kWriteRetryInterval = std::chrono::seconds(5);
/// Report of a child that has done its work.
constexpr const char* kDone = "done";

}  // namespace

bool is_taken_over(const MadeSafe& trace) {
  return trace.given_up.empty() && !trace.confirmed && trace.details.ends_with(kTakenOverWords);
}

TraceWriter::TraceWriter(const SafeState& safe_state, std::string because, std::string by)
    : safe_state_(safe_state), began_(SteadyClock().now().utc) {
  trace_ = {.at = began_,
            .because = std::move(because),
            .set_point = safe_state.safe_set_point,
            .confirmed = false,
            .details = {},
            .by = std::move(by)};
}

bool TraceWriter::record(const RescueResult& rescued) {
  start_pending_work();
  const bool confirmed = rescued.reached == SafeStage::all;
  const Shown shown{rescued.reached, rescued.is_ineffective, rescued.has_shown_commands};
  const bool may_wait = same_until_ && confirmed == trace_.confirmed && !confirmed;
  const auto& next_at = shown == shown_ ? same_until_ : changed_until_;
  if (may_wait && (rescued.details == trace_.details || !next_at->has_passed())) return false;
  // A confirmed chamber stays confirmed if a later attempt fails.
  if (trace_.confirmed && !confirmed) return false;
  shown_ = shown;
  same_until_.emplace(kMinTraceInterval);
  changed_until_.emplace(kMinChangeInterval);
  trace_.at = SteadyClock().now().utc;
  trace_.confirmed = confirmed;
  trace_.details = rescued.details;
  trace_to_write_ = true;
  start_pending_work();
  return true;
}

void TraceWriter::note_relay(std::string words) {
  trace_.relay = std::move(words);
  trace_to_write_ = true;
  start_pending_work();
}

void TraceWriter::note_given_up(std::string who_and_why) {
  trace_.at = SteadyClock().now().utc;
  trace_.given_up = std::move(who_and_why);
  trace_to_write_ = true;
  remove_safe_state();
}

void TraceWriter::remove_safe_state() {
  safe_state_to_remove_ = true;
  start_pending_work();
}

void TraceWriter::hand_over_to(const std::string& successor) {
  trace_.at = SteadyClock().now().utc;
  trace_.details = successor + std::string(kTakenOverWords);
  trace_to_write_ = safe_state_to_remove_ = true;
  start_pending_work();
}

/// Writes the trace and removes the files. Returns kDone, or the reason why the trace could not be written. Runs in a
/// child process.
std::string TraceWriter::carry_out(bool write, bool remove) const {
  const auto& record = safe_state_.record;
  const auto now = read_safe_state(safe_state_path(record));
  if (now && *now && (*now)->written_by != safe_state_.written_by) {
    if (!trace_.given_up.empty()) remove_give_up(record);
    return kDone;
  }
  if (write)
    if (const auto left = write_trace(record, trace_); !left) return text(left.error());
  if (remove) gyrotherm::watchdog::remove_safe_state(record);
  if (remove) remove_give_up(record);
  return kDone;
}

bool TraceWriter::collect_work(Duration within) {
  if (!writing_) return true;
  const Deadline deadline(within);
  while (auto line = writing_->next(deadline.left())) work_report_ = std::move(*line);
  if (!writing_->has_ended()) return false;
  writing_.reset();
  const bool is_done = work_report_ == kDone;
  write_fault_ = is_done ? "" : std::move(work_report_);
  retry_from_.reset();
  if (is_done) return true;
  retry_from_.emplace(kWriteRetryInterval);
  trace_to_write_ = trace_to_write_ || is_writing_trace_;
  safe_state_to_remove_ = safe_state_to_remove_ || is_removing_;
  return true;
}

/// Starts the pending work once the previous work is done, and not soon after a failure.
void TraceWriter::start_pending_work() {
  if (!collect_work({}) || !has_pending_work() || (retry_from_ && !retry_from_->has_passed())) return;
  is_writing_trace_ = std::exchange(trace_to_write_, false);
  is_removing_ = std::exchange(safe_state_to_remove_, false);
  work_report_.clear();
  writing_ = std::make_unique<ChildWork>(
      [this](const auto& send_line) { send_line(carry_out(is_writing_trace_, is_removing_)); });
}

bool TraceWriter::settle(Duration within) {
  const Deadline deadline(within);
  for (start_pending_work(); has_pending_work() && !deadline.has_passed(); start_pending_work())
    if (collect_work(deadline.left()) && retry_from_)
      std::this_thread::sleep_for(std::min(retry_from_->left(), deadline.left()));
  return !has_pending_work();
}

std::string TraceWriter::read_orders() const {
  if (const auto order = read_give_up(safe_state_.record); !order.empty()) return std::string(kGiveUp) + order;
  const auto now = read_safe_state(safe_state_path(safe_state_.record));
  if (!now) return kActive;
  if (*now) return (*now)->written_by == safe_state_.written_by ? kActive : kOtherRun;
  const auto left = read_trace(safe_state_.record);
  const bool by_another = left && *left && (*left)->confirmed && (*left)->at >= began_ && **left != trace_;
  return by_another ? kFulfilled : kGone;
}

std::optional<std::string> TraceWriter::find_end_reason() {
  if (!looking_) looking_ = std::make_unique<ChildWork>([this](const auto& send_line) { send_line(read_orders()); });
  const auto orders = looking_->next(kReadWithin);
  if (orders || looking_->has_ended()) looking_.reset();
  if (orders && orders->starts_with(kGiveUp)) {
    give_up_order_ = orders->substr(kGiveUp.size());
    return "ordered to give up by " + give_up_order_;
  }
  if (orders == kOtherRun) return "the run was resumed and has a guard of its own";
  is_fulfilled_ = orders == kFulfilled;
  if (is_fulfilled_) return "another program has made the chamber safe";
  if (orders == kActive) gone_until_.reset();
  if (orders == kGone && !gone_until_) gone_until_.emplace(kMissingTimeLimit);
  if (gone_until_ && gone_until_->has_passed()) return "the safe-state file has been missing for a day";
  return {};
}

}  // namespace gyrotherm::watchdog
