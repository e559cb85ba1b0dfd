// SPDX-License-Identifier: Apache-2.0
/// The over-temperature limiter of a virtual chamber: a thermostat of its own that switches heater and cooler off and
/// stays tripped until it is reset by hand. Faults make it fail in the ways that a proof test must find.
#pragma once

#include <limits>

namespace gyrotherm::simulator {

enum class LimiterFault {
  none,
  never_trips,
  trips_late,      ///< kLateTripK above its setting
  resets_itself,   ///< without a person, once the air is below its setting
  trips_early,     ///< kLateTripK below its setting
  shows_no_alarm,  ///< it trips, and the controller does not report it
};
inline constexpr double kLateTripK = 5;

class ChamberLimiter {
 public:
  /// Sets the temperature at which it trips, as the knob of a chamber does. It has no effect on a tripped limiter.
  void set(double highest_c) { highest_c_ = highest_c; }
  void reset() { is_tripped_ = false; }
  void inject(LimiterFault fault) { fault_ = fault; }

  /// Advances by one second with the air at this temperature.
  void step(double air_c) {
    const double off_k = fault_ == LimiterFault::trips_late    ? kLateTripK
                         : fault_ == LimiterFault::trips_early ? -kLateTripK
                                                               : 0;
    if (air_c > highest_c_ + off_k && fault_ != LimiterFault::never_trips) is_tripped_ = true;
    if (fault_ == LimiterFault::resets_itself && air_c < highest_c_) is_tripped_ = false;
  }

  [[nodiscard]] bool is_tripped() const { return is_tripped_; }
  [[nodiscard]] bool shows_alarm() const { return is_tripped_ && fault_ != LimiterFault::shows_no_alarm; }

 private:
  double highest_c_ = std::numeric_limits<double>::infinity();
  bool is_tripped_ = false;
  LimiterFault fault_ = LimiterFault::none;
};

}  // namespace gyrotherm::simulator
