// SPDX-License-Identifier: Apache-2.0
/// Instants and clocks. Code that needs the time is given a Clock. An instant is the monotonic time since the start of
/// the run, paired with UTC.
#pragma once

#include <chrono>
#include <string>

#include "core/quantity.hpp"

namespace gyrotherm {

/// One instant of a run.
struct Instant {
  /// Monotonic time since the start of the run, or of the clock.
  Duration since_start{};
  Duration utc{};  ///< since 1970-01-01T00:00:00Z
};

/// Source of the current time for every component.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Instant now() const = 0;
};

/// The machine's monotonic clock; each instant is paired with the system's UTC at the same moment.
class SteadyClock final : public Clock {
 public:
  /// Starts the clock at `elapsed`, the duration of a resumed run so far.
  explicit SteadyClock(Duration elapsed = {});
  [[nodiscard]] Instant now() const override;

 private:
  /// Start of the run, as time since boot.
  Duration origin_;
};

/// A clock that moves only when advance() is called. Its UTC starts at kVirtualEpoch plus `epoch_offset`; dry runs are
/// therefore reproducible.
class VirtualClock final : public Clock {
 public:
  explicit VirtualClock(Duration elapsed = {}, Duration epoch_offset = {})
      : elapsed_(elapsed), epoch_offset_(epoch_offset) {}
  [[nodiscard]] Instant now() const override;
  void advance(Duration by) { elapsed_ += by; }

 private:
  Duration elapsed_, epoch_offset_;
};

/// UTC at the start of every virtual clock: 2026-01-01T00:00:00Z.
inline constexpr Duration kVirtualEpoch = std::chrono::seconds(1767225600);

/// Returns the time since the machine was booted, including suspended time.
[[nodiscard]] Duration since_boot();
/// Returns an identifier of the current boot. Two processes that read the same identifier can compare their times since
/// boot, even if the system clock is changed.
[[nodiscard]] std::string boot_id();

/// Formats a UTC in whole seconds: "2026-01-01T00:00:00Z".
[[nodiscard]] std::string civil_time(Duration utc);

/// Formats a duration, rounded to seconds: "18 h 40 min 00 s", "40 min 00 s", "5 s".
[[nodiscard]] std::string format_duration(Duration d);

}  // namespace gyrotherm
