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
/// A soak counts while its sensor is inside the band, has been there for the dwell without leaving it, and moves no
/// faster than the slope. Leaving the band stops its clock and begins the dwell anew. A segment that passes its
/// deadline is Overdue: the rig's interlocks end the run.
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
  Duration inside{};  ///< how long the sensor has been in the band without leaving it
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

/// What a second brought: how long it was, and the sensor on which the segment soaks, if it is known: the air, or
/// what soak_sensor() names; and by how much it has moved over the last minute.
struct Observation {
  Duration elapsed{};
  std::optional<Celsius> air;
  std::optional<CelsiusPerMinute> slope{};
};

/// The state at the first second of the profile.
[[nodiscard]] ProfileState begin(const Profile& profile);

/// The state one observation later.
[[nodiscard]] ProfileState next(const Profile& profile, const ProfileState& state, const Observation& observation);

/// … in which the clock stood: a sensor that has left its band has to dwell in it anew.
[[nodiscard]] ProfileState stand(const Profile& profile, ProfileState state, const Observation& observation);

/// A segment that has passed its deadline has all of it before it once more, and what was soaked stays; any other state
/// stays as it is.
[[nodiscard]] ProfileState with_its_deadline_anew(ProfileState state);

/// The set point that the state asks for: a function of the state alone.
[[nodiscard]] Celsius demanded_set_point(const Profile& profile, const ProfileState& state);

/// Whether the unit is switched off by the profile's wish, or people may not have switched it on yet.
[[nodiscard]] bool unit_may_be_off(const Profile& profile, const ProfileState& state);

/// "air", or the channel of the thermometer that the present segment soaks on.
[[nodiscard]] const std::string& soak_sensor(const Profile& profile, const ProfileState& state);

/// The state as a record keeps it, and back: `state_of(profile, position_of(profile, s))` is `s`, but that a dwell
/// under way begins anew.
[[nodiscard]] ProfilePosition position_of(const Profile& profile, const ProfileState& state);
[[nodiscard]] Result<ProfileState> state_of(const Profile& profile, const ProfilePosition& progress);

/// Time left if every soak counts from now on.
[[nodiscard]] Duration time_left(const Profile& profile, const ProfileState& state);

}  // namespace gyrotherm::profile
