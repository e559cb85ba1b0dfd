// SPDX-License-Identifier: Apache-2.0
/// Remembers each instrument's behaviour to decide whether it still measures: frozen readings, dead gyros, thermometers
/// that do not respond, that jump or that drift. Values; any thread.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "sequencer/interlocks/limits.hpp"

namespace gyrotherm::interlocks {

/// Learns the noise of a channel from its own readings. Computes how improbable it is that noise alone leaves readings
/// identical.
class Noise {
 public:
  /// Adds a reading. `at_rest`: the quantity is not asked to change, so that what changes is noise.
  void add(double value, bool at_rest);

  /// Returns how many readings have been identical to the one before them, up to the last one.
  [[nodiscard]] int identical() const { return identical_; }
  /// Returns −ln of the probability that noise alone makes so many readings identical; 0 while no noise is known.
  [[nodiscard]] double improbability() const;

 private:
  std::optional<double> last_;
  double last_change_{};
  /// The smallest change seen: the resolution, or more.
  double step_ = std::numeric_limits<double>::infinity();
  /// The share of readings at rest that reverse the last change by two steps or more. Noise of such a size does not
  /// vanish between two steps of the resolution, wherever the quantity is.
  double share_{};
  int identical_{}, identical_at_rest_{};
};

/// An instrument all of whose readings are identical to the last digit.
struct Identity {
  int samples{};
  Duration lasts{};
  /// The longest earlier spell that was not taken for a frozen instrument.
  Duration longest_before{};
  std::optional<Celsius> air_before{};  ///< when it began
  Kelvins air_moved{};                  ///< since then, at most
  bool frozen{};
};

/// One axis of a gyro.
struct AxisLiveness {
  Noise noise;
  Duration identical{}, without_counts{};
  double arcsec{};   ///< counted in the block under way
  Duration block{};  ///< its length
  bool no_counts{}, frozen{};
  std::optional<DegreesPerHour> far{};  ///< rate of the last block

  [[nodiscard]] bool is_dead() const { return no_counts || frozen; }
};

/// Where air, set point and thermometers were when a thermometer last moved.
struct ResponseMemory {
  std::optional<Celsius> air{}, set_point{};
  std::vector<std::optional<Celsius>> thermometers{};
  Kelvins asked{};  ///< largest change of air, set point
};

/// One thermometer against its own past.
struct ThermometerPast {
  std::optional<Celsius> last{};
  Duration unseen{};  ///< since it was last read
  Kelvins jumped{};   ///< sum of jumps
};

struct LivenessMemory {
  std::vector<Noise> thermometers;    ///< one per column
  std::vector<Identity> instruments;  ///< order of InterlockLimits::instruments
  Noise air_noise;
  Identity air;
  std::vector<std::vector<AxisLiveness>> units;
  ResponseMemory response;
  std::vector<ThermometerPast> past;  ///< one per column
  std::optional<Celsius> set_point{};
  Duration at_rest{};     ///< since the set point moved
  bool units_were_off{};  ///< in the second before
};

/// Describes a second beside its sample.
struct LivenessSecond {
  Duration elapsed{};      ///< seen
  Duration missed{};       ///< before it, without ticks
  bool gyro_is_off{};      ///< units may be switched off
  bool units_are_moved{};  ///< an operator may move them
  bool is_turned{};        ///< input axes reversed
};

/// Takes a sample, as read, into the memory.
void remember(const InterlockLimits& limits, const Sample& sample, const LivenessSecond& second,
              LivenessMemory& memory);

/// Returns true if the thermometer belongs to an instrument that is frozen.
[[nodiscard]] bool is_frozen(const InterlockLimits& limits, const LivenessMemory& memory, std::size_t column);

/// Replaces the readings of frozen instruments and of dead gyros by faults. A chamber whose air is frozen stays: its
/// set point and its alarms are read.
void take_out_dead(const InterlockLimits& limits, const LivenessMemory& memory, Sample& sample);

}  // namespace gyrotherm::interlocks
