// SPDX-License-Identifier: Apache-2.0
/// Decides what a chamber that is being made safe has shown, and what to command next: for the safe sequence of a run
/// and for gyrotherm-make-safe alike. Pure.
#pragma once

#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/register_map.hpp"
#include "sequencer/watchdog/air_watch.hpp"

namespace gyrotherm::watchdog {

/// The usual [safe] observe.
inline constexpr Duration kUsualObserve = std::chrono::minutes(5);

/// The state in which the chamber is to be left.
struct SafeGoal {
  Celsius set_point;
  Kelvins tolerance;  ///< for the set point read back
  bool switch_off{};
  bool by_program{};              ///< the controller may carry out a program
  Duration observe = Duration{};  ///< 0: the air is not watched
  bool reads_back = true;         ///< the map reads the set point
  bool shows_mode{};              ///< the map has states
  bool shows_off{};               ///< and one of them is off
  bool can_start{}, can_stop{};   ///< the map has the command
  /// Identity that the chamber reported when the run began. Empty: its map alone is compared.
  std::string identity{};
};
/// Says how a set point is shown that the chamber has taken: some chambers cannot be asked for it.
[[nodiscard]] inline const char* shown_set_point(const SafeGoal& goal) {
  return goal.reads_back ? "set point read back" : "set point acknowledged";
}
[[nodiscard]] SafeGoal safe_goal(const drivers::RegisterMap& map, Celsius set_point, Duration observe);

enum class SafeAction {
  keep,       ///< look alone
  set_point,  ///< send the safe set point
  follow,     ///< write the mode that follows
  off,        ///< switch conditioning off
};

/// The chamber is safe when it has shown all three: the safe set point; the mode that follows it, or that it is off;
/// and air that moves towards it, or stays near it, for the time to observe. Air that moves away escalates: the mode is
/// written again; then the chamber is switched off, whatever the rig file says.
class SafeEvidence {
 public:
  explicit SafeEvidence(const SafeGoal& goal);

  /// The chamber has acknowledged what was sent.
  void acknowledge(SafeAction action);
  /// Takes a reading at `at` of a clock that never goes back.
  void see(const ChamberState& chamber, Duration at);

  /// Returns what is to be sent now. The caller decides how often the same is sent again.
  [[nodiscard]] SafeAction next() const;
  /// Returns true if the chamber is to be off, by the rig file or because nothing else helped.
  [[nodiscard]] bool wants_off() const;
  /// Returns true while the chamber, by its last reading, does what only an unsafe one does: the set point or the mode
  /// is not kept, or the air moves away.
  [[nodiscard]] bool is_ineffective() const { return ineffective_; }
  /// Returns true if switching off has failed, too.
  [[nodiscard]] bool is_out_of_means() const { return escalations_ > kMostEscalations; }

  [[nodiscard]] bool set_point_shown() const { return set_point_shown_; }
  [[nodiscard]] bool mode_shown() const { return mode_shown_; }
  [[nodiscard]] bool air_shown() const { return air_.verdict() == AirVerdict::shown; }
  [[nodiscard]] bool is_safe() const { return set_point_shown_ && mode_shown_ && air_shown(); }
  /// "set point read back; mode running; air 22.10 °C, 40.00 °C 5 min before: near 22 °C"
  [[nodiscard]] std::string describe() const;

 private:
  static constexpr int kMostEscalations = 3;

  [[nodiscard]] bool judge_mode() const;
  [[nodiscard]] AirSource source() const;
  void watch_air(Celsius air, Duration at, bool was_complete);
  void escalate(Celsius air, Duration at);

  SafeGoal goal_;
  AirWatch air_;    ///< with set point and mode shown
  AirWatch trend_;  ///< at all times
  std::optional<Celsius> shown_;
  ChamberActivity activity_ = ChamberActivity::unknown;
  bool taken_ = false, switched_off_ = false, follow_due_ = false;
  bool set_point_shown_ = false, mode_shown_ = false;
  std::optional<Duration> mode_wrong_since_;
  int escalations_ = 0;
  bool ineffective_ = false;
  std::string trouble_;  ///< of the air, when it became so
};

}  // namespace gyrotherm::watchdog
