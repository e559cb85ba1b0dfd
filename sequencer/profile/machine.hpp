// SPDX-License-Identifier: Apache-2.0
/// The profile's state machine: pure, one step per second, no clock and no I/O.
///
// clang-format off
///          set point reaches the target              time is up (inside the band, if the soak is guaranteed)
///   Ramping ──────────────────────────▶ next ◀────────────────────────────────── Holding
///      ▲                                 │ next segment, or                       ▲  │ air leaves the band, or is not
///      └─────────────────────────────────┤ Complete after the last                │  ▼ known (guaranteed soak only)
///                                        └──────────────────────────────────▶ WaitingForSoak
// clang-format on
///
/// The time of a soak counts while its sensor is inside the band, has been inside without a break for the dwell, and
/// changes no faster than the slope. Leaving the band stops the soak's clock and restarts the dwell. A segment that
/// passes its deadline is Overdue, and the rig's interlocks end the run.
#pragma once

#include <optional>
#include <variant>

#include "core/sample.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::profile {

struct Ramping {
  int segment{};
  Duration elapsed{};
};
struct Holding {
  int segment{};
  Duration elapsed{};
  Duration soaked{};
  /// Time since the sensor last entered the band.
  Duration inside{};
};
struct WaitingForSoak {
  int segment{};
  Duration elapsed{};
  Duration soaked{};
  Duration inside{};
};
struct Overdue {
  int segment{};
  Duration elapsed{};
  Duration soaked{};
};
struct Complete {};
using ProfileState = std::variant<Ramping, Holding, WaitingForSoak, Overdue, Complete>;

/// The inputs of one step: its length, the reading of the segment's soak sensor, and the change of that reading over
/// the last minute. soak_sensor() names the sensor: the air or a thermometer.
struct Observation {
  Duration elapsed{};
  std::optional<Celsius> air;
  std::optional<CelsiusPerMinute> slope{};
};

/// Returns the state at the first second of the profile.
[[nodiscard]] ProfileState begin(const Profile& profile);

/// Returns the state after one observation. An open profile (released_blocks.hpp) does not end: the clock of its last
/// hold stops one step before the end.
[[nodiscard]] ProfileState next(const Profile& profile, const ProfileState& state, const Observation& observation);

/// Returns the state after one observation in which the profile's clock was stopped. A sensor outside its band restarts
/// its dwell.
[[nodiscard]] ProfileState next_while_paused(const Profile& profile, ProfileState state,
                                             const Observation& observation);

/// Restarts the deadline of an overdue segment and keeps its soak time. Returns every other state unchanged.
[[nodiscard]] ProfileState restart_deadline(ProfileState state);

/// Returns the set point of a state. Depends only on the state.
[[nodiscard]] Celsius demanded_set_point(const Profile& profile, const ProfileState& state);

/// Returns true if the profile requires the unit to be off, or if the operator may not have switched it on yet.
[[nodiscard]] bool unit_may_be_off(const Profile& profile, const ProfileState& state);

/// Returns "air", the channel of the thermometer that the current segment soaks on, or kColdestThermometer.
[[nodiscard]] const std::string& soak_sensor(const Profile& profile, const ProfileState& state);

/// Converts a state to its stored form and back. `restore_state(profile, profile_position(profile, s))` is `s`, except
/// that a dwell in progress starts again.
[[nodiscard]] ProfilePosition profile_position(const Profile& profile, const ProfileState& state);
[[nodiscard]] Result<ProfileState> restore_state(const Profile& profile, const ProfilePosition& progress);

/// Returns the remaining time if no soak is interrupted from now on.
[[nodiscard]] Duration time_left(const Profile& profile, const ProfileState& state);

}  // namespace gyrotherm::profile
