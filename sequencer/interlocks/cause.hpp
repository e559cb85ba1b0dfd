/// What can be wrong with a rig, as the interlocks tell it apart; each cause has one reaction and one alarm.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace gyrotherm {

/// What an interlock asks for, the milder first.
enum class Reaction { go_on, warn, suspend, hold, abort };
struct InterlockDemand {
  Reaction reaction = Reaction::go_on;
  std::string cause;  ///< empty when nothing is wrong
};

[[nodiscard]] const char* name(Reaction reaction);

enum class InterlockId {
  air_limit,          ///< the chamber's air is beyond a limit
  thermometer_limit,  ///< a thermometer is
  chamber_alarm,      ///< the chamber has an alarm that ends a run, its limiter's among them
  emergency_stop,     ///< its emergency stop is pressed
  deadline,           ///< a segment has passed its deadline
  program,            ///< a controller no longer carries out the profile that it was given
  chamber_sensor,     ///< the chamber's own sensor contradicts the thermometers
  chamber_silent,
  thermometers_lost,    ///< fewer answer than are needed
  needed_channel_lost,  ///< a thermometer without which the run cannot be evaluated gives no reading
  gyro_silent,
  door,               ///< open
  supply,             ///< the chamber has lost its own
  air_rate,           ///< the air changes faster than a closed chamber can
  thermometer_rate,   ///< the article changes faster than it may
  following,          ///< the air does not follow the set point
  foreign_set_point,  ///< somebody else has changed it, or switched the chamber off
  restarted,          ///< the chamber came back otherwise than it was left
  not_taken,          ///< the chamber does not take set points
  slept,              ///< the machine stood still for longer than a run may be left alone
  storage,            ///< the record is behind, or loses rows
  record_damaged,     ///< another program has removed, replaced or changed a file of the record
  unguarded,          ///< nobody would make the chamber safe if this program died
  channel_lost,       ///< a thermometer gives no reading
  disagreement,       ///< a thermometer is far from the others
  stuck,              ///< a thermometer does not move while the others do
  wall_clock,         ///< the time of day was stepped
};
inline constexpr std::size_t kCauses = 27;

/// The reaction unless the rig file's [policy] says otherwise.
[[nodiscard]] Reaction usual_reaction(InterlockId cause);
/// Whether [policy] may say otherwise: what would damage the article always ends the run.
[[nodiscard]] bool may_be_chosen(InterlockId cause);

/// "chamber_silent", as [policy] spells it.
[[nodiscard]] const char* name(InterlockId cause);

using Policy = std::array<Reaction, kCauses>;
[[nodiscard]] Policy usual_policy();

}  // namespace gyrotherm
