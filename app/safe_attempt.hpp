/// Making one chamber safe: its safe set point written and read back, and conditioning ended where the rig wants it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/armed_file.hpp"
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

/// At most three tries, and none that begins later than seven seconds after the first.
[[nodiscard]] SafeAttempt attempt_safe(Celsius safe_set_point, bool switch_off, const AttemptMeans& means);

struct ArmedChamber {
  std::string place;  ///< of its lock (drivers/chamber/chamber_lock.hpp)
  std::function<std::unique_ptr<Chamber>()> connect;
};
/// The chamber that the armed file describes. Fails with bad_file.
[[nodiscard]] Result<ArmedChamber> chamber_of(const Armed& armed);

}  // namespace gyrotherm
