// SPDX-License-Identifier: Apache-2.0
/// Decides whether a chamber has shown that it is safe, and chooses the next command. Used by the safe sequence of a
/// run and by gyrotherm-make-safe. Pure.
#pragma once

#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "core/rig_defaults.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/register_map.hpp"
#include "sequencer/watchdog/air_watch.hpp"

namespace gyrotherm::watchdog {

/// The required final state of the chamber, and the capabilities of its map.
struct SafeGoal {
  Celsius set_point;
  /// Permitted deviation of the set point that is read back.
  Kelvins tolerance;
  bool switch_off{};
  /// True if a program may run in the controller. It is ended before the set point is sent.
  bool by_program{};
  /// 0: the air is not watched.
  Duration observe = Duration{};
  /// The map can read the set point back.
  bool reads_back = true;
  bool shows_mode{};  ///< the map has states
  /// One of its states is off.
  bool shows_off{};
  bool can_start{}, can_stop{};  ///< the map has the command
  /// Identity that the chamber reported when the run began. Empty: only its map is compared.
  std::string identity{};
};
/// Describes the evidence of an accepted set point: some chambers cannot read it back.
[[nodiscard]] inline const char* shown_set_point(const SafeGoal& goal) {
  return goal.reads_back ? "set point read back" : "set point acknowledged";
}
[[nodiscard]] SafeGoal safe_goal(const drivers::RegisterMap& map, Celsius set_point, Duration observe);

enum class SafeAction {
  keep,       ///< only read
  set_point,  ///< send the safe set point
  follow,     ///< write the mode that follows
  off,        ///< switch conditioning off
};

/// Collects the evidence. The chamber is safe when it has shown all three: the safe set point; the mode that follows
/// it, or that it is off; and air that approaches the set point, or stays near it, for the time to observe. Air that
/// moves away escalates: first the mode is written again; then the chamber is switched off, regardless of the rig file.
class SafeEvidence {
 public:
  explicit SafeEvidence(const SafeGoal& goal);

  /// Records that the chamber has acknowledged a command.
  void acknowledge(SafeAction action);
  /// Adds a reading at `at` of a monotonic clock.
  void add_reading(const ChamberState& chamber, Duration at);

  /// Returns the command to send now. The caller decides how often it is repeated.
  [[nodiscard]] SafeAction next() const;
  /// Returns true if the chamber must be switched off: the rig file requires it, or everything else had no effect.
  [[nodiscard]] bool must_be_off() const;
  /// Returns true from an escalation until is_safe(). An escalation begins when the air moves away from the set point
  /// or does not approach it, or when the set point or the mode has not been shown for a minute.
  [[nodiscard]] bool is_ineffective() const { return ineffective_; }
  /// Returns true if the chamber is off, and its air nevertheless moves away after the time to observe.
  [[nodiscard]] bool is_drifting() const { return air_.is_drifting(); }
  /// Returns true if further commands are useless: switching off has also failed, or the chamber is off and has refused
  /// the set point for a minute.
  [[nodiscard]] bool is_exhausted() const;

  /// Returns true if the chamber has acknowledged the command that switches it off, or shows that it is off.
  [[nodiscard]] bool is_switched_off() const;
  [[nodiscard]] bool has_shown_set_point() const { return set_point_shown_; }
  [[nodiscard]] bool has_shown_mode() const { return mode_shown_; }
  [[nodiscard]] bool has_shown_air() const { return air_.verdict() == AirVerdict::shown; }
  [[nodiscard]] bool is_safe() const { return set_point_shown_ && mode_shown_ && has_shown_air(); }
  /// Returns a text such as "set point read back; mode running; air 22.10 °C, 40.00 °C 5 min before: near 22 °C". The
  /// values are those of the last reading. `now` is the time of the text on the clock of add_reading(); the text
  /// contains the age of a reading that is older than 5 s.
  [[nodiscard]] std::string describe(std::optional<Duration> now = {}) const;

 private:
  static constexpr int kMaxEscalations = 3;

  [[nodiscard]] bool judge_mode() const;
  [[nodiscard]] AirSource source() const;
  void watch_air(Celsius air, Duration at, bool was_complete);
  void escalate(Celsius air, Duration at);
  [[nodiscard]] std::string describe_air() const;

  SafeGoal goal_;
  /// Judges the air, but only while the chamber reports the safe set point and mode.
  AirWatch air_;
  AirWatch trend_;  ///< at all times
  std::optional<Celsius> shown_;
  ChamberActivity activity_ = ChamberActivity::unknown;
  bool is_accepted_ = false, switched_off_ = false, follow_due_ = false;
  bool set_point_shown_ = false, mode_shown_ = false;
  std::optional<Duration> set_point_wrong_since_, mode_wrong_since_;
  std::optional<Duration> off_without_set_point_since_;
  int escalations_ = 0;
  bool ineffective_ = false;
  /// Movement of the air that caused the last escalation; empty: it was not the air.
  std::string past_movement_;
  Duration escalated_at_{};
  std::optional<Duration> last_at_;  ///< time of the last reading
  Celsius last_air_{};
};

}  // namespace gyrotherm::watchdog
