// SPDX-License-Identifier: Apache-2.0
/// Time is handed in: an instant is monotonic time since the run started, paired with UTC.
#pragma once

#include <chrono>
#include <string>

#include "core/quantity.hpp"

namespace gyrotherm {

/// A moment of a run.
struct Instant {
  Duration since_start{};  ///< monotonic, from the start of the run (or of the clock)
  Duration utc{};          ///< since 1970-01-01T00:00:00Z
};

/// Where everything that must know the time gets it from.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Instant now() const = 0;
};

/// The machine's monotonic clock; each instant is paired with the system's UTC of that moment.
class SteadyClock final : public Clock {
 public:
  /// A run that this process resumes has lasted `already`, which is where the clock goes on.
  explicit SteadyClock(Duration already = {});
  [[nodiscard]] Instant now() const override;

 private:
  Duration origin_;  ///< when the run began, since the machine was started
};

/// A clock that moves only when told. Its UTC starts at kVirtualEpoch or so much later, so that dry runs are
/// reproducible.
class VirtualClock final : public Clock {
 public:
  explicit VirtualClock(Duration already = {}, Duration later = {}) : elapsed_(already), later_(later) {}
  [[nodiscard]] Instant now() const override;
  void advance(Duration by) { elapsed_ += by; }

 private:
  Duration elapsed_, later_;
};

/// The UTC at which every virtual clock starts: 2026-01-01T00:00:00Z.
inline constexpr Duration kVirtualEpoch = std::chrono::seconds(1767225600);

/// The time since the machine was started, its sleep included; and an id of that start. Instants that two processes
/// note by both can be compared although somebody sets the machine's clock.
[[nodiscard]] Duration since_boot();
[[nodiscard]] std::string boot_id();

/// Writes a UTC in whole seconds: "2026-01-01T00:00:00Z".
[[nodiscard]] std::string civil_time(Duration utc);

/// Writes a duration for people: "18 h 40 min 00 s".
[[nodiscard]] std::string spoken(Duration d);

}  // namespace gyrotherm
