// SPDX-License-Identifier: Apache-2.0
/// Tracks each instrument over time to detect one that no longer measures: frozen readings, dead gyros, and
/// thermometers that do not respond, jump or drift. Plain values; any thread.
#pragma once

#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "sequencer/interlocks/limits.hpp"

namespace gyrotherm::interlocks {

/// Learns the noise of a channel from its readings, and computes how improbable a spell of identical readings is with
/// that noise.
class Noise {
 public:
  /// Adds a reading. `at_rest` is true if the set point is constant, so a change of the reading is noise.
  void add(double value, bool at_rest);

  /// Counts the latest readings that are identical to the one before them.
  [[nodiscard]] int identical() const { return identical_; }
  /// Returns −ln of the probability of the current spell of identical readings; 0 while the noise is unknown.
  [[nodiscard]] double improbability() const;
  /// Returns the smallest change so far; infinity if there was none.
  [[nodiscard]] double step() const { return step_; }

 private:
  std::optional<double> last_;
  double last_change_{};
  /// The smallest change so far: the resolution, or a multiple of it.
  double step_ = std::numeric_limits<double>::infinity();
  /// Fraction of readings at rest that reverse the last change by two steps or more. Noise of that amplitude changes
  /// the readings at any value of the quantity, despite rounding.
  double share_{};
  int identical_{}, identical_at_rest_{};
};

/// The latest readings of one channel, up to a minute of them.
class LastMinute {
 public:
  void add(double value);
  [[nodiscard]] std::optional<double> last() const;
  /// Returns the mean change per reading; 0 before there are enough readings.
  [[nodiscard]] double pace() const;

 private:
  std::deque<double> values_;
};

/// A channel that moved when a spell of identical readings began.
struct MovingChannel {
  double pace{};  ///< K per reading, before the spell
  double step{};  ///< K
  /// Movement of the air since the beginning, in the direction of the channel, in K.
  double air_ahead{};
  /// Steps that are missing in the spell, because the air did not turn back.
  double missing_steps{};
};

/// A spell of identical readings of one instrument: every channel repeats its last reading.
struct IdenticalSpell {
  int samples{};
  Duration duration{};
  /// Longest earlier spell of this kind that was not declared frozen.
  Duration longest_before{};
  std::optional<Celsius> air_before{};  ///< at the spell's beginning
  /// Largest change of the air since then.
  Kelvins air_moved{};
  /// Channels that moved at the spell's beginning.
  std::vector<MovingChannel> moving{};
  bool frozen{};
};

/// The state of one axis of a gyro.
struct AxisLiveness {
  Noise noise;
  Duration identical{}, without_counts{};
  /// Angle counted in the current block.
  double arcsec{};
  Duration block{};  ///< its length
  bool no_counts{}, frozen{};
  /// Rate of the last block if it was far from the Earth's rate; otherwise absent.
  std::optional<DegreesPerHour> deviating_rate{};

  [[nodiscard]] bool is_dead() const { return no_counts || frozen; }
};

/// Air, set point and thermometers when a thermometer last moved.
struct ResponseMemory {
  std::optional<Celsius> air{}, set_point{};
  std::vector<std::optional<Celsius>> thermometers{};
  /// Change of the air or of the set point since then, whichever is larger.
  Kelvins demanded_change{};
};

/// Change between two readings of a channel, and the time between them.
struct MotionStep {
  Kelvins change{};
  Duration time{};
};

/// The motion of a channel over its latest readings.
class RecentMotion {
 public:
  /// Adds a second. `value` is empty if it has no reading; its time then counts to the next step.
  void add(const std::optional<Celsius>& value, Duration elapsed);

  /// Returns the change since the previous reading; empty if this second has no reading, or no reading precedes it.
  [[nodiscard]] std::optional<MotionStep> step() const;
  /// Returns the speed of the last step, or the mean speed of the latest steps if that is more; in K/s, in the
  /// direction of `sign`.
  [[nodiscard]] double fastest(double sign) const;
  /// Returns fastest() of a motion that lasts. A single fast step counts only with its share of the mean, because it
  /// may be a jump.
  [[nodiscard]] double sustained(double sign) const;
  /// Returns the mean speed before the last step, in K/s, in the direction of `sign`.
  [[nodiscard]] double previous(double sign) const;
  [[nodiscard]] const std::optional<Celsius>& last() const { return last_; }

 private:
  /// Returns the mean speed without the latest `omitted` steps, in K/s.
  [[nodiscard]] double mean(std::size_t omitted = 0) const;

  std::optional<Celsius> last_;
  Duration unseen_{};  ///< since the last reading
  bool has_step_{};
  std::deque<MotionStep> steps_;
};

/// A jump among the latest readings. It is withdrawn if the air or the other thermometers then move as fast.
struct RecentJump {
  MotionStep step;
  std::size_t age{};  ///< readings since then
};

/// The motion of one thermometer, and the sum of its jumps.
struct ThermometerPast {
  RecentMotion motion;
  std::vector<RecentJump> recent_jumps{};
  /// Sum of the changes that were too fast to be real.
  Kelvins jumped{};
};

struct LivenessMemory {
  std::vector<Noise> thermometers;          ///< one per column
  std::vector<LastMinute> last_minute;      ///< one per column
  std::vector<IdenticalSpell> instruments;  ///< order of InterlockLimits::instruments
  Noise air_noise;
  IdenticalSpell air;
  std::vector<std::vector<AxisLiveness>> units;
  ResponseMemory response;
  std::vector<ThermometerPast> past;  ///< one per column
  RecentMotion air_motion;
  std::optional<Celsius> set_point{};  ///< when it last moved
  /// Time since the set point last moved, or a unit was switched on or off.
  Duration at_rest{};
  /// The units were possibly off in the previous second.
  bool units_were_off{};
};

/// Facts about a second that its sample does not contain.
struct LivenessSecond {
  Duration elapsed{};  ///< time with ticks
  /// Time without ticks before this second.
  Duration missed{};
  /// True if the units may be switched off. Their rates are then not checked.
  bool gyro_is_off{};
  /// True if an operator may be moving the units. Rates are then not compared with the Earth rate.
  bool units_are_moved{};
  bool is_turned{};  ///< input axes reversed
};

/// Adds a sample, as read, to the memory.
void remember(const InterlockLimits& limits, const Sample& sample, const LivenessSecond& second,
              LivenessMemory& memory);

/// Returns true if the thermometer belongs to an instrument that is frozen.
[[nodiscard]] bool is_frozen(const InterlockLimits& limits, const LivenessMemory& memory, std::size_t column);

/// Replaces the readings of frozen instruments and of dead gyros by faults. Keeps the reading of a chamber whose air is
/// frozen, because it also contains the set point and the alarms.
void mask_dead_readings(const InterlockLimits& limits, const LivenessMemory& memory, Sample& sample);

}  // namespace gyrotherm::interlocks
