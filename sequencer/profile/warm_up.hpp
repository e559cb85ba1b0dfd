// SPDX-License-Identifier: Apache-2.0
/// Warm-ups: segments that a run adds to a profile so that a unit is warmer than the dew point of the air around the
/// chamber when the door is opened. Pure; any thread.
#pragma once

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::profile {

/// The air around a chamber, which enters when its door is opened.
struct RoomAir {
  /// The default is 60 % relative humidity at 23 °C.
  Celsius dew_point{14.8};
  /// Covers the uncertainty of dew point and thermometers.
  Kelvins margin{2};

  /// Returns the lowest temperature at which a unit may meet this air.
  [[nodiscard]] Celsius warm_from() const { return dew_point + margin; }
};

/// Returns the warm-up for this air in a chamber with these limits. Its air is at least 5 K above the required
/// temperature of the unit and at least at 25 °C, as far as the chamber permits.
[[nodiscard]] WarmUp make_warm_up(const RoomAir& room, const ChamberLimits& limits);

/// Adds a warm-up after the last segment if its target is below the required temperature, and before each segment that
/// opens the door while the set point is below it. A warm-up is a ramp and a hold that waits for the coldest
/// thermometer. After one before a door, another ramp returns to the profile's set point; it has the prompt, and the
/// unit state of the segment. If the run ends by itself, the warm-up at the end follows the closing segments. Changes
/// nothing if the profile has warm_up = false. Fails with usage if a warm-up is
/// required and its air is not above the required temperature of the unit.
[[nodiscard]] Result<void> add_warm_ups(Profile& profile, const WarmUp& warm_up);

}  // namespace gyrotherm::profile
