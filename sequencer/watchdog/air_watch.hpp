// SPDX-License-Identifier: Apache-2.0
/// Watches the air of a chamber that is being made safe: an acknowledged set point does not prove that the air follows.
/// docs/decisions/0036 gives the reasons for the constants. Pure.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "core/quantity.hpp"

namespace gyrotherm::watchdog {

/// The cause of the air's movement, as far as it is known.
enum class AirSource {
  /// The controller brings the air to the set point.
  controller,
  /// An off command was acknowledged.
  switched_off,
  /// The chamber reports that it is off.
  seen_off,
};

enum class AirVerdict {
  watching,  ///< undecided
  /// The air behaves as in a safe chamber.
  shown,
  /// The air is farther from the set point than before.
  moves_away,
  /// The air is neither near the set point nor approaching it.
  does_not_move,
};

/// Air within this distance of the set point has arrived.
inline constexpr Kelvins kSafeBand{2};

class AirWatch {
 public:
  AirWatch(Celsius set_point, Duration observe) : set_point_(set_point), observe_(observe) {}

  /// Clears all readings and sets the source. The air of a chamber that is switched off may drift to any ambient
  /// temperature.
  void begin(AirSource source);
  /// Adds a reading at `at` of a monotonic clock. Returns the verdict so far.
  AirVerdict add_reading(Celsius air, Duration at);

  [[nodiscard]] AirVerdict verdict() const { return verdict_; }
  [[nodiscard]] AirSource source() const { return source_; }
  [[nodiscard]] bool has_reading() const { return last_at_.has_value(); }
  /// Returns the time for which the air has been watched. At most half a minute of a pause between two readings is
  /// included.
  [[nodiscard]] Duration watched() const { return watched_; }
  /// Returns true if only a quick drift away from the set point keeps the watch from ending.
  [[nodiscard]] bool is_drifting() const { return watched_ >= observe_ && drifts_off_quickly(now_c_); }
  /// Returns a text such as "air 40.10 °C, 61.30 °C 5 min before: moves towards 22 °C".
  [[nodiscard]] std::string describe() const;
  /// Returns what the air did when the verdict was reached, for a later message, such as "moved AWAY from 23 °C, from
  /// 99.80 °C to 103.00 °C within 25 s". Empty unless the verdict is moves_away or does_not_move.
  [[nodiscard]] std::string describe_past() const;

 private:
  [[nodiscard]] double distance(double air_c) const;
  [[nodiscard]] AirVerdict judge(double air_c) const;
  [[nodiscard]] bool drifts_off_quickly(double air_c) const;

  Celsius set_point_;
  Duration observe_;
  AirSource source_ = AirSource::controller;
  AirVerdict verdict_ = AirVerdict::watching;
  Duration watched_{};
  std::optional<Duration> last_at_;
  /// Watched time (see watched()) at which the air came near the set point; absent: it is not near.
  std::optional<Duration> near_since_;
  std::optional<double> last_c_, before_c_;  ///< the two newest readings
  double first_c_{}, now_c_{};               ///< medians of three readings
  /// The medians of the last minute with their watched times, oldest first.
  std::deque<std::pair<Duration, double>> last_minute_;
  double nearest_k_{}, farthest_k_{};
};

}  // namespace gyrotherm::watchdog
