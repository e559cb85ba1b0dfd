// SPDX-License-Identifier: Apache-2.0
/// The interlocks by name, and the tables of a rig file that say what they watch and how they react: [limits],
/// [policy], [safe]. docs/interlocks.md describes every key. Values; any thread.
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

namespace gyrotherm::interlocks {

/// What an interlock asks for, the milder first.
enum class Reaction { go_on, warn, suspend, hold, abort };
/// The word as [policy] and the record spell it.
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
  wall_clock,
  end  ///< is none: it counts them
};
inline constexpr auto kInterlocks = static_cast<std::size_t>(InterlockId::end);

/// The reaction to each interlock.
using Policy = std::array<Reaction, kInterlocks>;
/// The policy of a rig file that has no [policy].
[[nodiscard]] Policy usual_policy();

/// The temperatures between which one thermometer is to stay.
struct ThermometerLimits {
  Celsius lowest{-60};
  Celsius highest{100};
};

/// One input axis of a unit under test.
struct AxisLimits {
  std::string label;  ///< "gyro", "u1.x"
  double arcsec_per_count{};
  std::optional<DegreesPerHour> earth_rate{};    ///< on the axis; unknown: nothing
  std::optional<DegreesPerHour> largest_bias{};  ///< of a good unit; not stated: nothing
};

/// One of the units under test.
struct UnitLimits {
  std::string name;
  bool go_on_when_silent{};                 ///< the run goes on for the others
  std::vector<std::size_t> thermometers{};  ///< columns of those that its analysis cannot do without
  std::vector<AxisLimits> axes{};           ///< sample order; may be empty
  std::vector<std::string> analogue{};      ///< names of what analogue inputs measure of it, in the sample's order
};

/// Names the thermometers that one instrument reads.
struct InstrumentChannels {
  std::string name;                       ///< "thermometer 1"
  std::vector<std::size_t> columns = {};  ///< of the sample
};

/// "u1.discharge_current_a": the channel of such a value, where the file gives it a name.
[[nodiscard]] inline std::string analogue_channel(const UnitLimits& unit, std::size_t index) {
  return fmt::format("{}.{}", unit.name,
                     index < unit.analogue.size() ? unit.analogue[index] : std::to_string(index + 1));
}

/// What the interlocks compare a sample with: [limits] and [policy] of the rig file.
struct InterlockLimits {
  Celsius air_lowest{-60};  ///< for the chamber's own sensor
  Celsius air_highest{100};
  Celsius thermometers_lowest{-60};  ///< for each thermometer on the unit under test
  Celsius thermometers_highest{100};
  std::vector<ThermometerLimits> thermometers;  ///< one per channel, or none where the file gives none of its own
  std::vector<std::string> channels;            ///< the thermometers' names, for messages; may be empty
  std::vector<InstrumentChannels> instruments;  ///< instruments of the thermometers; may be empty
  int confirming_samples = 2;                   ///< readings in a row beyond a limit before it counts

  CelsiusPerMinute air_fastest{20};  ///< over a minute; magnitude
  CelsiusPerMinute thermometers_fastest{15};
  Kelvins disagreement{60};          ///< between a thermometer and the median of all
  Kelvins chamber_disagreement{10};  ///< between the chamber's sensor and the median of the thermometers in the
                                     ///< air; without these, of the sensor and itself before it jumped
  std::vector<std::size_t> air_thermometers;  ///< columns of those that hang in the air

  Duration suspend_after = std::chrono::seconds(5);  ///< a silence that suspends
  Duration chamber_lost = std::chrono::minutes(10);  ///< silence that ends the run
  Duration thermometers_lost = std::chrono::minutes(10);
  Duration gyro_lost = std::chrono::minutes(60);
  int thermometers_needed = 1;    ///< fewer that answer are a silence
  std::vector<UnitLimits> units;  ///< in the order of the sample's; may be empty: they have no names

  Duration chamber_lag = std::chrono::minutes(2);  ///< first-order, of the air behind the set point
  Kelvins follow_band{2};
  Duration follow_time = std::chrono::minutes(5);

  Duration frozen_after = std::chrono::seconds(60);     ///< shortest spell of identical readings
  Duration gyro_dead_after = std::chrono::seconds(60);  ///< shortest spell without counts
  std::optional<DegreesPerHour> gyro_band{};            ///< around the Earth's rate; not stated: from the bias
  Kelvins response_step{20};                            ///< change of air or set point
  Duration response_time = std::chrono::minutes(30);    ///< until a thermometer has followed
  Kelvins drift{1.5};                                   ///< largest unexplained jump

  Duration backlog = std::chrono::seconds(60);      ///< how far the record may be behind before it is an alarm
  Duration clear_after = std::chrono::seconds(10);  ///< an alarm is over when its cause has been gone for so long
  Policy policy = usual_policy();
};

/// How an operator's stop leaves the chamber. An abort always makes it safe.
enum class OnStop { hold, safe };

/// What a run does whose terminal is closed.
enum class OnHangup { go_on, safe };

/// How long the states of a run may last, and how an operator's stop leaves the chamber: [limits] and [safe].
struct RunLimits {
  Duration longest_suspended = std::chrono::hours(2);  ///< then the run is aborted
  Duration longest_held = std::chrono::hours(12);      ///< then the run aborts
  Duration longest_return = std::chrono::hours(4);     ///< then the run aborts
  Duration resume_delay = std::chrono::seconds(10);    ///< how long a cause is gone before the run goes on
  OnStop on_stop = OnStop::safe;
  OnHangup on_hangup = OnHangup::go_on;
};

/// Reads [limits] and [policy]; every mistake is noted in the tables. `channels` are the rig's thermometers, in order;
/// `chamber` is what air_fastest follows from where the file does not have it.
[[nodiscard]] InterlockLimits read_limits(const TomlTable& root, const std::vector<std::string>& channels,
                                          const profile::ChamberLimits& chamber);

/// Reads the run's own keys of [limits], and [safe]; every mistake is noted in the tables.
[[nodiscard]] RunLimits read_run_limits(const TomlTable& root);

}  // namespace gyrotherm::interlocks
