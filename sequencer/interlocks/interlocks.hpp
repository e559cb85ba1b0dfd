/// The conditions under which a run may go on. Pure: limits, what was seen, and what is remembered go in, a verdict
/// comes out; it outranks the profile.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/sample.hpp"
#include "sequencer/interlocks/cause.hpp"
#include "sequencer/interlocks/trend.hpp"

namespace gyrotherm {

/// Of one thermometer.
struct ThermometerLimits {
  Celsius lowest{-60};
  Celsius highest{100};
};

/// From the rig file's [limits] and [policy]; docs/interlocks.md has the table.
struct InterlockLimits {
  Celsius air_lowest{-60};  ///< of the chamber's own sensor
  Celsius air_highest{100};
  Celsius thermometers_lowest{-60};  ///< of each thermometer on the article
  Celsius thermometers_highest{100};
  std::vector<ThermometerLimits> thermometers;  ///< of each one, where the file has limits of its own; else empty
  std::vector<std::string> channels;            ///< their names, for messages; may be empty
  int confirming_samples = 2;                   ///< readings in a row beyond a limit before it counts

  CelsiusPerMinute air_fastest{20};  ///< over a minute; magnitude
  CelsiusPerMinute thermometers_fastest{15};
  Kelvins disagreement{60};                   ///< of a thermometer and the median of all
  Kelvins chamber_disagreement{10};           ///< of the chamber's sensor and the median of the thermometers in the
                                              ///< air; without these, of the sensor and itself before it jumped
  std::vector<std::size_t> air_thermometers;  ///< columns of those that hang in the air

  Duration suspend_after = std::chrono::seconds(5);  ///< of silence
  Duration chamber_lost = std::chrono::minutes(10);  ///< silence that ends the run
  Duration thermometers_lost = std::chrono::minutes(10);
  Duration gyro_lost = std::chrono::minutes(60);
  int thermometers_needed = 1;                   ///< fewer that answer are a silence
  std::vector<std::size_t> needed_thermometers;  ///< columns of those that the analysis cannot do without

  Duration chamber_lag = std::chrono::minutes(2);  ///< first-order, of the air behind the set point
  Kelvins follow_band{2};
  Duration follow_time = std::chrono::minutes(5);

  Duration backlog = std::chrono::seconds(60);      ///< of the record, before it is an alarm
  Duration clear_after = std::chrono::seconds(10);  ///< an alarm is over when its cause has been gone for so long
  Policy policy = usual_policy();
};

/// What the rig knows beside the sample.
struct InterlockInputs {
  std::optional<Celsius> sent{};     ///< the set point that the chamber last took; nothing: it is not known
  Kelvins set_point_tolerance{0.1};  ///< what the controller may make of it
  int refusals{};                    ///< set points in a row that it did not take
  std::string refusal{};             ///< why
  std::string program{};             ///< what is wrong with a program that the controller carries out
  bool led_by_controller{};          ///< set points are the controller's own
  Duration missed{};                 ///< time without ticks just before this one
  Duration longest_missed = std::chrono::seconds(120);
  Duration backlog{};  ///< of the record
  bool rows_dropped{};
  std::string storage_trouble{};  ///< why the disk takes no rows
  std::string record_damage{};    ///< what another program did to the record's files
  std::string guard_trouble{};    ///< why nobody would make the chamber safe
};

/// What the interlocks remember from second to second.
struct InterlockMemory {
  struct Watch {
    Duration standing{};                  ///< how long the cause is there
    int samples{};                        ///< … in how many samples
    Duration unseen{};                    ///< since what shows it was last read
    Duration gone{};                      ///< how long it is not there, or not seen to be
    bool raised{};                        ///< its alarm
    Reaction reaction{};                  ///< what it asked for when it was last seen
    std::optional<std::size_t> column{};  ///< of the thermometer that showed it
    std::string text{};                   ///< as last seen
  };
  std::array<Watch, kCauses> watches{};
  [[nodiscard]] const Watch& of(InterlockId cause) const { return watches[static_cast<std::size_t>(cause)]; }
  bool chamber_answered = true;  ///< in the sample before
  bool activity_seen = true;     ///< the chamber has said what it does since it was last silent
  Trend air;
  std::vector<Trend> thermometers;
  std::optional<Celsius> expected{};  ///< the air, as it would follow the set point
  Kelvins lag{};                      ///< how far that is behind the set point; fades three times as slowly
  std::optional<Celsius> set_point{};
  std::optional<Celsius> air_seen{};  ///< the last that was known
  Duration air_unseen{};              ///< since then
  Kelvins air_jumped{};               ///< in all, over degrees that it did not pass through
  std::optional<Duration> utc_minus_run{};
};

struct InterlockAlarm {
  InterlockId cause{};
  Reaction reaction{};
  std::string text;
};
struct InterlockResult {
  InterlockDemand demand;
  InterlockMemory memory;
  std::vector<InterlockAlarm> raised;   ///< with this sample: one alarm per cause until it is over
  std::vector<InterlockAlarm> cleared;  ///< with this sample
};

/// Judges one sample that covers `elapsed`. The most severe reaction wins.
[[nodiscard]] InterlockResult judge(const InterlockLimits& limits, InterlockMemory memory, const Sample& sample,
                                    Duration elapsed, const InterlockInputs& inputs = {});

/// One line for each alarm that stands.
[[nodiscard]] std::vector<std::string> standing(const InterlockMemory& memory);

}  // namespace gyrotherm
