// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/safe_sequence.hpp"

#include <fmt/format.h>

#include "core/clock.hpp"

namespace gyrotherm::run {
namespace {

using watchdog::SafeAction;

constexpr Duration kInitialAttemptTime = std::chrono::seconds(10);
constexpr Duration kLaterAttemptInterval = std::chrono::seconds(10);
constexpr Duration kReportInterval = std::chrono::seconds(60);
/// Number of seconds in a row without a reading after which the sequence does not progress.
constexpr int kUnreadToReport = 3;

bool is_due(const std::optional<Duration>& last, Duration at, Duration every) { return !last || at - *last >= every; }

watchdog::SafeGoal make_goal(const rig::RigFile& rig) {
  auto goal = watchdog::safe_goal(rig.chamber_map, rig.safe_set_point, rig.safe_observe);
  goal.switch_off = rig.safe_off;
  return goal;
}

}  // namespace

SafeSequence::SafeSequence(const rig::RigFile& rig) : target_(rig.safe_set_point), evidence_(make_goal(rig)) {}

/// Sends the set point, then the mode. If nothing else had an effect, switches the chamber off, even if it refuses the
/// set point.
Result<void> SafeSequence::carry_out(io::InstrumentIo& io, bool at_once) {
  Result<void> sent;
  if (evidence_.next() == SafeAction::set_point) {
    sent = at_once ? io.send_safe_set_point(target_, evidence_.must_be_off()) : io.send_set_point(target_);
    if (sent) evidence_.acknowledge(SafeAction::set_point);
  }
  const auto action = evidence_.next();
  if (!at_once || action == SafeAction::keep) return sent;
  if (action == SafeAction::set_point && !(evidence_.is_ineffective() && evidence_.must_be_off())) return sent;
  const bool off = evidence_.must_be_off();
  auto switched = io.switch_on(!off);
  mode_trouble_ = switched ? "" : text(switched.error());
  if (switched) evidence_.acknowledge(off ? SafeAction::off : SafeAction::follow);
  return sent ? switched : sent;
}

std::optional<std::string> SafeSequence::attempt(io::InstrumentIo& io, Duration at) {
  if (!began_) began_ = at;
  now_ = at;
  const bool at_once = at - *began_ < kInitialAttemptTime || is_due(forced_, at, kLaterAttemptInterval);
  if (at_once) forced_ = at;
  const auto done = carry_out(io, at_once);
  if (evidence_.next() == SafeAction::keep) mode_trouble_.clear();
  // A command that failed and is not repeated in this second still has to succeed.
  trouble_ = done ? mode_trouble_ : text(done.error());
  if (!is_failing() || !is_due(reported_, at, kReportInterval)) return std::nullopt;
  reported_ = at;
  return describe() + "; further attempts follow";
}

void SafeSequence::add_reading(const Reading<ChamberState>& chamber, Duration at) {
  now_ = at;
  if (!began_) return;
  unread_ = chamber.value ? 0 : unread_ + 1;
  if (!chamber.value) read_trouble_ = text(chamber.value.error());
  if (!chamber.value) return;
  evidence_.add_reading(*chamber.value, at);
  confirmed_ = evidence_.is_safe();
}

bool SafeSequence::is_failing() const {
  return !trouble_.empty() || evidence_.is_ineffective() || evidence_.is_drifting() || unread_ >= kUnreadToReport;
}

bool SafeSequence::is_only_being_watched() const {
  return evidence_.has_shown_set_point() && evidence_.has_shown_mode() && !evidence_.is_ineffective();
}

watchdog::RelayDue SafeSequence::relay_due() const {
  using watchdog::RelayDue;
  if (confirmed_) return RelayDue::never;
  const bool is_answering = unread_ < kUnreadToReport;
  if (is_answering && evidence_.is_ineffective()) return RelayDue::now;
  const bool has_shown_commands = evidence_.has_shown_set_point() && evidence_.has_shown_mode();
  return is_answering && has_shown_commands ? RelayDue::never : RelayDue::in_time;
}

/// Returns the commands that the chamber has acknowledged: "sent to 20 °C and switched off".
std::string SafeSequence::describe_commands() const {
  const auto off = !evidence_.must_be_off()      ? ""
                   : evidence_.is_switched_off() ? " and switched off"
                                                 : ", but NOT switched off";
  return fmt::format("sent to {:g} °C{}", target_.value, off);
}

std::string SafeSequence::describe() const {
  const auto what = describe_commands();
  auto shown = evidence_.describe(now_);
  if (unread_ >= kUnreadToReport)
    shown += fmt::format("; no reading for {}: {}", format_duration(std::chrono::seconds(unread_)), read_trouble_);
  if (confirmed_) return fmt::format("the chamber was {} ({})", what, shown);
  const bool is_acknowledged = began_ && trouble_.empty() && !evidence_.is_ineffective();
  if (is_acknowledged || is_only_being_watched())
    return fmt::format("the chamber was {}, and is NOT confirmed safe yet ({})", what, shown);
  if (trouble_.empty() && evidence_.has_shown_set_point() && evidence_.has_shown_mode())
    return fmt::format("the chamber was {}, but its air does NOT follow ({}){}", what, shown,
                       evidence_.must_be_off() ? "; cut its power" : "");
  const auto failed = evidence_.has_shown_set_point() && evidence_.must_be_off()
                          ? fmt::format("was sent to {:g} °C, but could NOT be switched off", target_.value)
                          : fmt::format("could NOT be sent to {:g} °C{}", target_.value,
                                        evidence_.must_be_off() ? " and switched off" : "");
  return fmt::format("the chamber {} ({}{}{})", failed, trouble_, trouble_.empty() ? "" : "; ", shown);
}

}  // namespace gyrotherm::run
