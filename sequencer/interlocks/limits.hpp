// SPDX-License-Identifier: Apache-2.0
/// The names of the interlocks, and the tables of a rig file that configure them: [limits], [policy], [safe].
/// docs/interlocks.md describes every key. Values; any thread.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/profile/warm_up.hpp"

namespace gyrotherm::interlocks {

/// Reactions of an interlock, from the mildest to the most severe.
enum class Reaction { go_on, warn, suspend, hold, abort };
/// Returns the keyword of a reaction in [policy] and in the record.
[[nodiscard]] const char* name(Reaction reaction);

/// Every interlock. Each has its row in the table of interlocks.cpp, in this order.
enum class InterlockId {
  air_limit,
  thermometer_limit,
  chamber_alarm,
  emergency_stop,
  deadline,
  program,
  chamber_sensor,
  chamber_silent,
  thermometers_lost,
  needed_channel_lost,
  gyro_silent,
  unit_silent,
  door,
  supply,
  air_rate,
  thermometer_rate,
  following,
  frozen,
  gyro_dead,
  no_thermal_response,
  power_limit,
  power_trip,
  power_changed,
  power_not_switched,
  another_instrument,
  foreign_set_point,
  not_following,
  restarted,
  restarted_off,
  not_taken,
  slept,
  storage,
  record_damaged,
  unguarded,
  channel_lost,
  disagreement,
  stuck,
  drifting,
  condensation,
  cold_at_door,
  wall_clock,
  end  ///< number of interlocks
};
inline constexpr auto kInterlocks = static_cast<std::size_t>(InterlockId::end);

/// The reaction to each interlock.
using Policy = std::array<Reaction, kInterlocks>;
/// Returns the policy of a rig file without [policy].
[[nodiscard]] Policy default_policy();

/// The permitted temperatures of one thermometer.
struct ThermometerLimits {
  Celsius lowest{-60};
  Celsius highest{100};
};

/// One input axis of a unit under test.
struct AxisLimits {
  std::string label;  ///< "gyro", "u1.x"
  double arcsec_per_count{};
  /// Component of the Earth's rate along the axis; absent: unknown.
  std::optional<DegreesPerHour> earth_rate{};
  /// Largest bias of a good unit; absent: not stated.
  std::optional<DegreesPerHour> largest_bias{};
};

/// One of the units under test.
struct UnitLimits {
  std::string name;
  /// If this unit is silent, the run continues with the other units.
  bool continue_when_silent{};
  /// Columns of the thermometers that the unit's analysis requires.
  std::vector<std::size_t> thermometers{};
  /// Axes in sample order; may be empty.
  std::vector<AxisLimits> axes{};
  /// Names of the unit's analogue inputs, in sample order.
  std::vector<std::string> analogue{};
};

/// The thermometers that one instrument reads.
struct InstrumentChannels {
  std::string name;  ///< "thermometer 1"
  /// Columns of the sample.
  std::vector<std::size_t> columns = {};
};

/// Returns the channel of an analogue input: "u1.discharge_current_a" if the rig file names it, otherwise its number.
[[nodiscard]] inline std::string analogue_channel(const UnitLimits& unit, std::size_t index) {
  return fmt::format("{}.{}", unit.name,
                     index < unit.analogue.size() ? unit.analogue[index] : std::to_string(index + 1));
}

/// The limits of the interlocks: [limits] and [policy] of the rig file.
struct InterlockLimits {
  Celsius air_lowest{-60};  ///< chamber's own sensor
  Celsius air_highest{100};
  /// Limits of each thermometer on the unit under test.
  Celsius thermometers_lowest{-60};
  Celsius thermometers_highest{100};
  /// One per channel; empty if the rig file gives no limits of single channels.
  std::vector<ThermometerLimits> thermometers;
  /// Names of the thermometers, for messages; may be empty.
  std::vector<std::string> channels;
  /// Instruments of the thermometers; may be empty.
  std::vector<InstrumentChannels> instruments;
  /// Number of readings outside a limit before the interlock acts.
  int confirming_samples = 2;

  /// Fastest permitted changes, as magnitudes over a minute.
  CelsiusPerMinute air_fastest{20};
  CelsiusPerMinute thermometers_fastest{15};
  /// Difference between a thermometer and the median of all.
  Kelvins disagreement{60};
  /// Difference between the chamber's sensor and the median of the thermometers in the air. Without such thermometers:
  /// the largest jump of the chamber's sensor.
  Kelvins chamber_disagreement{10};
  /// Columns of the thermometers that measure the chamber's air and not a unit.
  std::vector<std::size_t> air_thermometers;

  Duration suspend_after = std::chrono::seconds(5);  ///< silence that suspends
  /// Silence that ends the run.
  Duration chamber_lost = std::chrono::minutes(10);
  Duration thermometers_lost = std::chrono::minutes(10);
  Duration gyro_lost = std::chrono::minutes(60);
  /// Number of thermometers that must answer. If fewer answer, the interlock thermometers_lost acts.
  int thermometers_needed = 1;
  /// Units in sample order; empty: the units have no names.
  std::vector<UnitLimits> units;

  /// Time constant with which the air follows the set point (first order).
  Duration chamber_lag = std::chrono::minutes(2);
  Kelvins follow_band{2};
  Duration follow_time = std::chrono::minutes(5);

  /// Shortest duration of identical readings that can be a fault.
  Duration frozen_after = std::chrono::seconds(60);
  /// Shortest duration without counts that can be a fault.
  Duration gyro_dead_after = std::chrono::seconds(60);
  /// Permitted deviation from the Earth's rate; absent: computed from the unit's largest bias.
  std::optional<DegreesPerHour> gyro_band{};
  /// Change of the air or the set point to which at least one thermometer must respond.
  Kelvins response_step{20};
  /// Time within which it must respond.
  Duration response_time = std::chrono::minutes(30);
  Kelvins drift{1.5};  ///< largest unexplained jump

  /// Smallest difference between the coldest thermometer of the units and the dew point of the chamber.
  Kelvins condensation_margin{1};
  /// Air that enters when the door is opened; absent: no person opens the door of a virtual rig.
  std::optional<profile::RoomAir> room{};

  /// Largest delay of the record without an alarm.
  Duration backlog = std::chrono::seconds(60);
  /// An alarm clears when its cause has been absent for this time.
  Duration clear_after = std::chrono::seconds(10);
  Policy policy = default_policy();
};

/// State of the chamber after an operator's stop. An abort always makes it safe.
enum class OnStop { hold, safe };

/// Reaction of a run when its terminal closes.
enum class OnHangup { go_on, safe };

/// Longest durations of a run's states, and its reactions to a stop and a hangup: [limits] and [safe].
struct RunLimits {
  /// A run aborts after this time in the state Suspended.
  Duration longest_suspended = std::chrono::hours(2);
  /// A run aborts after this time in the state Held.
  Duration longest_held = std::chrono::hours(12);
  /// A run aborts after this time in the state Returning.
  Duration longest_return = std::chrono::hours(4);
  /// Time without a cause before the run resumes.
  Duration resume_delay = std::chrono::seconds(10);
  OnStop on_stop = OnStop::safe;
  OnHangup on_hangup = OnHangup::go_on;
};

/// Reads [limits] and [policy], and records every error in the tables. `channels` are the rig's thermometers, in order.
/// The default of air_fastest depends on `chamber`.
[[nodiscard]] InterlockLimits read_limits(const TomlTable& root, const std::vector<std::string>& channels,
                                          const profile::ChamberLimits& chamber);

/// Reads the run's own keys of [limits], and [safe]. Records every error in the tables.
[[nodiscard]] RunLimits read_run_limits(const TomlTable& root);

}  // namespace gyrotherm::interlocks
