/// Time is handed in: an instant is monotonic time since the run started, paired with UTC.
#pragma once

#include <chrono>
#include <string>

#include "core/quantity.hpp"

namespace gyrotherm {

struct Instant {
  Duration since_start{};  ///< monotonic, from the start of the run (or of the clock)
  Duration utc{};          ///< since 1970-01-01T00:00:00Z
};

class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Instant now() const = 0;
};

/// The machine's monotonic clock; each instant is paired with the system's UTC of that moment.
class SteadyClock final : public Clock {
 public:
  /// `already`: how long the run lasted before this process took it up (resume).
  explicit SteadyClock(Duration already = {});
  [[nodiscard]] Instant now() const override;

 private:
  Duration origin_;  ///< since the machine was started
};

/// A clock that moves only when told. Its UTC starts at kVirtualEpoch, so that dry runs are reproducible.
class VirtualClock final : public Clock {
 public:
  explicit VirtualClock(Duration already = {}) : elapsed_(already) {}
  [[nodiscard]] Instant now() const override;
  void advance(Duration by) { elapsed_ += by; }

 private:
  Duration elapsed_;
};

/// 2026-01-01T00:00:00Z.
inline constexpr Duration kVirtualEpoch = std::chrono::seconds(1767225600);

/// Since the machine was started, its sleep included, and which start that was: for what must be compared across
/// processes although somebody sets the clock.
[[nodiscard]] Duration since_boot();
[[nodiscard]] std::string boot_id();

/// "2026-01-01T00:00:00Z", whole seconds.
[[nodiscard]] std::string civil_time(Duration utc);

/// "18 h 40 min 00 s", for people.
[[nodiscard]] std::string spoken(Duration d);

}  // namespace gyrotherm
