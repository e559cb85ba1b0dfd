// SPDX-License-Identifier: Apache-2.0
/// Watches the air of a chamber that is being made safe: an acknowledged set point does not show that the air follows.
/// docs/decisions/safe-is-an-effect.md gives the reasons for the numbers. Pure.
#pragma once

#include <optional>
#include <string>

#include "core/quantity.hpp"

namespace gyrotherm::watchdog {

/// The cause of the movement of the air, as far as it is known.
enum class AirSource {
  controller,    ///< brings it to the set point
  switched_off,  ///< an acknowledged command alone
  seen_off,      ///< the chamber shows it
};

enum class AirVerdict {
  watching,      ///< undecided
  shown,         ///< a safe chamber does so
  moves_away,    ///< farther than it was
  stands_still,  ///< neither near nor coming
};

/// Air within this distance of the set point has arrived.
inline constexpr Kelvins kSafeBand{2};

class AirWatch {
 public:
  AirWatch(Celsius set_point, Duration observe) : set_point_(set_point), observe_(observe) {}

  /// Forgets what was seen. Air of a chamber that is switched off may drift to any temperature of a room.
  void begin(AirSource source);
  /// Takes a reading at `at` of a clock that never goes back. Returns the verdict so far.
  AirVerdict see(Celsius air, Duration at);

  [[nodiscard]] AirVerdict verdict() const { return verdict_; }
  [[nodiscard]] AirSource source() const { return source_; }
  /// Returns how long the air has been seen. A pause between two readings counts for half a minute at most.
  [[nodiscard]] Duration watched() const { return watched_; }
  /// "air 40.10 °C, 61.30 °C 5 min before: moves towards 22 °C"
  [[nodiscard]] std::string describe() const;

 private:
  [[nodiscard]] double distance(double air_c) const;
  [[nodiscard]] AirVerdict judge(double air_c) const;

  Celsius set_point_;
  Duration observe_;
  AirSource source_ = AirSource::controller;
  AirVerdict verdict_ = AirVerdict::watching;
  Duration watched_{};
  std::optional<Duration> last_at_;
  std::optional<Duration> near_since_;       ///< on the scale of watched_
  std::optional<double> last_c_, before_c_;  ///< the two newest readings
  double first_c_{}, now_c_{};               ///< medians of three readings
  double nearest_k_{}, farthest_k_{};
};

}  // namespace gyrotherm::watchdog
