// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/safe_evidence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/clock.hpp"

namespace gyrotherm::watchdog {
namespace {

/// A controller takes a set point and changes its mode within this time, even on a slow line.
constexpr Duration kTakenWithin = std::chrono::seconds(60);
/// A reading that is older is described with its age.
constexpr Duration kMaxFreshAge = std::chrono::seconds(5);
constexpr int kSwitchesOff = 2;  ///< the escalation that switches off

/// Returns true if nothing conditions the air: the chamber is off, or its own protection prevents conditioning.
bool is_off(ChamberActivity activity) {
  switch (activity) {
    case ChamberActivity::off:
    case ChamberActivity::alarm:
    case ChamberActivity::door_open:
    case ChamberActivity::emergency_stop:
    case ChamberActivity::power_failure: return true;
    default: return false;
  }
}

}  // namespace

SafeGoal safe_goal(const drivers::RegisterMap& map, Celsius set_point, Duration observe) {
  SafeGoal goal{.set_point = set_point, .tolerance = set_point_tolerance(map), .observe = observe};
  const auto* set_point_item = map.find("set_point");
  goal.reads_back = set_point_item != nullptr && set_point_item->readable;
  goal.shows_mode = !map.states.empty();
  goal.shows_off = std::ranges::count(map.states, ChamberActivity::off, &drivers::StateRule::activity) > 0;
  goal.can_start = map.control || map.sequences.contains("start");
  goal.can_stop = drivers::can_stop(map);
  return goal;
}

SafeEvidence::SafeEvidence(const SafeGoal& goal)
    : goal_(goal), air_(goal.set_point, goal.observe), trend_(goal.set_point, Duration::max()) {}

void SafeEvidence::acknowledge(SafeAction action) {
  if (action == SafeAction::set_point) is_accepted_ = true;
  if (action == SafeAction::follow) follow_due_ = false;
  if (action == SafeAction::off) switched_off_ = true;
}

bool SafeEvidence::must_be_off() const { return goal_.switch_off || (escalations_ >= kSwitchesOff && goal_.can_stop); }

bool SafeEvidence::is_switched_off() const { return switched_off_ || activity_ == ChamberActivity::off; }

bool SafeEvidence::is_exhausted() const {
  const bool refuses =
      off_without_set_point_since_ && last_at_ && *last_at_ - *off_without_set_point_since_ > kTakenWithin;
  return refuses || escalations_ > kMaxEscalations;
}

bool SafeEvidence::judge_mode() const {
  const bool unseen = activity_ == ChamberActivity::unknown;
  // A chamber with an open door conditions again when it is closed, unless it has been switched off.
  if (must_be_off()) return is_switched_off() && (is_off(activity_) || (unseen && !goal_.shows_off));
  return is_off(activity_) || activity_ == ChamberActivity::running || (unseen && !goal_.shows_mode);
}

AirSource SafeEvidence::source() const {
  if (is_off(activity_)) return AirSource::seen_off;
  return must_be_off() && switched_off_ && mode_shown_ ? AirSource::switched_off : AirSource::controller;
}

/// Escalates by one step. First the mode is written again. Then, or if nothing conditions the air already, the chamber
/// is switched off.
void SafeEvidence::escalate(Celsius air, Duration at) {
  ineffective_ = true;
  past_movement_ = trend_.verdict() == AirVerdict::moves_away ? trend_.describe_past() : air_.describe_past();
  escalated_at_ = at;
  // A refused set point has been sent again and again, so only the off command is left.
  const bool is_last_resort =
      is_off(activity_) || (set_point_wrong_since_ && at - *set_point_wrong_since_ > kTakenWithin);
  escalations_ = is_last_resort ? std::max(escalations_ + 1, kSwitchesOff) : escalations_ + 1;
  follow_due_ = !must_be_off() && goal_.can_start && activity_ != ChamberActivity::unknown && !is_off(activity_);
  is_accepted_ = switched_off_ = false;
  mode_wrong_since_.reset();
  set_point_wrong_since_.reset();
  air_.begin(source());
  trend_.begin(source());
  (void)trend_.add_reading(air, at);
}

void SafeEvidence::watch_air(Celsius air, Duration at, bool was_complete) {
  const bool complete = set_point_shown_ && mode_shown_;
  if (trend_.source() != source()) trend_.begin(source());
  if (complete != was_complete || air_.source() != source()) air_.begin(source());
  const auto trend = trend_.add_reading(air, at);
  const auto verdict = complete ? air_.add_reading(air, at) : AirVerdict::watching;
  const auto is_refused = [at](const std::optional<Duration>& since) { return since && at - *since > kTakenWithin; };
  if (trend == AirVerdict::moves_away || verdict == AirVerdict::moves_away || verdict == AirVerdict::does_not_move ||
      is_refused(set_point_wrong_since_) || is_refused(mode_wrong_since_))
    escalate(air, at);
  if (is_safe()) ineffective_ = false;
}

void SafeEvidence::add_reading(const ChamberState& chamber, Duration at) {
  const bool was_complete = set_point_shown_ && mode_shown_;
  shown_ = chamber.set_point;
  last_at_ = at;
  last_air_ = chamber.air;
  activity_ = chamber.activity;
  const bool unreadable = std::isnan(chamber.set_point.value);
  const bool has_set_point = abs(chamber.set_point - goal_.set_point) <= goal_.tolerance;
  is_accepted_ = has_set_point || (is_accepted_ && unreadable);  // even without an acknowledgement
  set_point_shown_ = is_accepted_;
  if (switched_off_ && activity_ == ChamberActivity::running) switched_off_ = false;
  mode_shown_ = judge_mode();
  const auto note_wrong = [at](bool is_shown, std::optional<Duration>& since) {
    since = is_shown ? std::nullopt : since ? since : std::optional(at);
  };
  note_wrong(set_point_shown_ || is_off(activity_), set_point_wrong_since_);
  note_wrong(mode_shown_, mode_wrong_since_);
  note_wrong(set_point_shown_ || !is_off(activity_), off_without_set_point_since_);
  watch_air(chamber.air, at, was_complete);
}

SafeAction SafeEvidence::next() const {
  if (!is_accepted_) return SafeAction::set_point;
  if (must_be_off()) return is_switched_off() ? SafeAction::keep : SafeAction::off;
  const bool wrong = !mode_shown_ && activity_ != ChamberActivity::unknown;
  return (wrong || follow_due_) && goal_.can_start ? SafeAction::follow : SafeAction::keep;
}

/// Describes the present air. After an escalation also the movement that caused it, with its time.
std::string SafeEvidence::describe_air() const {
  const auto& watch = air_.has_reading() ? air_ : trend_;
  if (!ineffective_ || past_movement_.empty()) return watch.describe();
  const auto since = std::chrono::floor<std::chrono::seconds>(last_at_.value_or(escalated_at_) - escalated_at_);
  const auto when = since > Duration{} ? format_duration(since) + " before it " : "it ";
  return fmt::format("air {:.2f} °C; {}{}", last_air_.value, when, past_movement_);
}

std::string SafeEvidence::describe(std::optional<Duration> now) const {
  std::string set_point = "the set point has not been read";
  if (shown_ && std::isnan(shown_->value))
    set_point = is_accepted_ ? "set point acknowledged" : "set point NOT acknowledged";
  if (shown_ && !std::isnan(shown_->value))
    set_point =
        set_point_shown_ ? shown_set_point(goal_) : fmt::format("set point NOT shown: reads {:g} °C", shown_->value);
  auto mode = fmt::format("mode {}{}", mode_shown_ ? "" : "NOT shown: ", name(activity_));
  if (activity_ == ChamberActivity::unknown)
    mode = goal_.shows_mode ? "mode NOT shown"
           : switched_off_  ? "switched off, as acknowledged"
                            : "mode not in its map";
  const auto age = now && last_at_ ? std::chrono::floor<std::chrono::seconds>(*now - *last_at_) : Duration{};
  const auto aged = age > kMaxFreshAge ? fmt::format(" (read {} ago)", format_duration(age)) : "";
  return fmt::format("{}; {}; {}{}", set_point, mode, describe_air(), aged);
}

}  // namespace gyrotherm::watchdog
