/// Making one chamber safe: its safe set point written and read back, and conditioning ended where the rig wants it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/guard/armed_file.hpp"
#include "core/clock.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"

namespace gyrotherm {

struct SafeAttempt {
  bool confirmed{};
  int tries{};
  std::string details;  ///< what the chamber says now, or the last fault
};

/// What an attempt needs of the world.
struct AttemptMeans {
  std::function<std::unique_ptr<Chamber>()> connect;  ///< a new connection for each try: no rest, no stale reply
  std::function<void(Duration)> wait;
  const Clock& clock;
};

inline constexpr int kSafeTries = 3;
inline constexpr Duration kSafeWithin = std::chrono::seconds(10);

/// How the chamber is to be left.
struct SafeGoal {
  Celsius set_point;
  Kelvins tolerance;  ///< of the set point that it shows then (drivers/chamber/set_point_tolerance.hpp)
  bool switch_off{};
};

/// At most three tries, and none that begins later than seven seconds after the first.
[[nodiscard]] SafeAttempt attempt_safe(const SafeGoal& goal, const AttemptMeans& means);

struct ArmedChamber {
  std::string place;  ///< of its lock (drivers/chamber/chamber_lock.hpp)
  SafeGoal goal;
  std::function<std::unique_ptr<Chamber>()> connect;
};
/// The chamber that the armed file describes, by its map. Fails with bad_file.
[[nodiscard]] Result<ArmedChamber> chamber_of(const Armed& armed);

}  // namespace gyrotherm
