// SPDX-License-Identifier: Apache-2.0
/// Making one chamber safe: its safe set point first, written and read back with nothing else asked on the way, for on
/// a bad line each question more is one that may be lost; then a program of the controller's own ended, and
/// conditioning too where the rig wants it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/clock.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "sequencer/watchdog/child_work.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::watchdog {

/// How far an attempt has come.
enum class SafeStage {
  nothing,
  set_point,  ///< the chamber has shown the safe set point: what matters most
  all,        ///< the chamber is also left as the rig wants it
};

struct SafeAttempt {
  SafeStage reached{};
  int tries{};          ///< how often the set point was sent
  std::string details;  ///< what the chamber says now, or the last fault
};

/// What an attempt needs of the world.
struct AttemptMeans {
  std::function<std::unique_ptr<drivers::Chamber>()> connect;  ///< a new connection: no rest, no stale reply
  std::function<void(Duration)> wait;
  std::function<void(const SafeAttempt&)> told;  ///< is told each stage that is reached, and each fault
  const Clock& clock;
};

inline constexpr Duration kSafeWithin = std::chrono::seconds(10);  ///< the set point, if the chamber answers

/// How the chamber is to be left.
struct SafeGoal {
  Celsius set_point;
  Kelvins tolerance;  ///< how often the set point was sent that it shows then (drivers/chamber/set_point_tolerance.hpp)
  bool switch_off{};
  bool by_program{};  ///< the controller may carry a program out, which would overrule a set point
  /// Identity that the chamber reported when the run began. Empty: its map alone is compared.
  std::string identity{};
};

/// Tries the set point again and again on one connection (on a new one after a line that broke), the last time before
/// eight seconds are over; once the chamber has shown it, the rest, three times at most.
[[nodiscard]] SafeAttempt attempt_safe(const SafeGoal& goal, const AttemptMeans& means);

struct SafeStateChamber {
  std::string place;  ///< names its lock (drivers/chamber/chamber_lock.hpp)
  SafeGoal goal;
  std::function<std::unique_ptr<drivers::Chamber>()> connect;
};
/// The chamber that the safe-state file describes, by its map. Fails with bad_file.
[[nodiscard]] Result<SafeStateChamber> chamber_of(const SafeState& safe_state);

struct Rescued {
  SafeStage reached{};
  std::string details;
  bool in_use{};     ///< another program has the chamber by now: nothing was tried
  bool is_driven{};  ///< that program drives it, and does not make it safe
};

/// Holds the chamber's lock meanwhile. Without it, it acts all the same, unless a program of this user or of root that
/// drives chambers or makes them safe has it by now, does not stand still, and is not the one that has gone: one that
/// is dying keeps its lock while it hangs in the disk, and a stranger who holds it must not keep a chamber hot. An
/// attempt that hangs is ended, after ten seconds or, once the chamber has shown the safe set point, after fifteen
/// more.
[[nodiscard]] Rescued attempt_once(const SafeState& safe_state, const SafeStateChamber& chamber, Voice& voice);

}  // namespace gyrotherm::watchdog
