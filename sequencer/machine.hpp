/// The sequencer's state machine: pure, one step per second, no clock and no I/O.
///
///            set point reaches the target             time is up (inside the band, if the soak is guaranteed)
///   Ramping ───────────────────────────▶ next ◀────────────────────────────────── Holding
///      ▲                                  │ next segment, or                          ▲  │ air leaves the band, or is
///      not known └──────────────────────────────────┤ Complete after the last                   │  ▼ (guaranteed soak
///      only)
///                                         └──────────────────────────────────────▶ WaitingForSoak
///
/// A segment that passes its deadline is Overdue: the rig's interlocks end the run.
#pragma once

#include <optional>
#include <variant>

#include "core/sample.hpp"
#include "sequencer/profile.hpp"

namespace gyrotherm {

struct Ramping {
  int segment{};
  Duration elapsed{};
};
struct Holding {
  int segment{};
  Duration elapsed{};
  Duration soaked{};
};
struct WaitingForSoak {
  int segment{};
  Duration elapsed{};
  Duration soaked{};
};
struct Overdue {
  int segment{};
  Duration elapsed{};
  Duration soaked{};
};
struct Complete {};
using State = std::variant<Ramping, Holding, WaitingForSoak, Overdue, Complete>;

/// What a second brought: how long it was, and the air if it is known.
struct Observation {
  Duration elapsed{};
  std::optional<Celsius> air;
};

/// The state at the first second of the profile.
[[nodiscard]] State begin(const Profile& profile);

/// The state one observation later.
[[nodiscard]] State next(const Profile& profile, const State& state, const Observation& observation);

/// The set point that the state asks for: a function of the state alone.
[[nodiscard]] Celsius command(const Profile& profile, const State& state);

/// The state as a record keeps it, and back: `state_of(profile, progress_of(profile, s))` is `s`.
[[nodiscard]] Progress progress_of(const Profile& profile, const State& state);
[[nodiscard]] Result<State> state_of(const Profile& profile, const Progress& progress);

/// Time left if every soak counts from now on.
[[nodiscard]] Duration time_left(const Profile& profile, const State& state);

}  // namespace gyrotherm
