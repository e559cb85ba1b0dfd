// SPDX-License-Identifier: Apache-2.0
/// The time of one line in memory. A wait on one line does not delay the others, as if each line had its own worker.
#pragma once

#include <algorithm>

#include "core/clock.hpp"

namespace gyrotherm::faults {

/// The rig's clock. The test advances it, and can step its UTC.
class SimulatedClock final : public Clock {
 public:
  [[nodiscard]] Instant now() const override { return {elapsed_, kVirtualEpoch + elapsed_ + step_}; }
  void advance(Duration by) { elapsed_ += by; }
  void step_utc(Duration by) { step_ += by; }
  /// Sets the time since the start of the run, for a program that starts now.
  void restart_at(Duration elapsed) { elapsed_ = elapsed; }

 private:
  Duration elapsed_{}, step_{};
};

/// Runs ahead of the rig's clock by the time waited.
class LineClock final : public Clock {
 public:
  explicit LineClock(const Clock& rig) : rig_(rig) {}
  [[nodiscard]] Instant now() const override { return {time(), {}}; }
  [[nodiscard]] Duration time() const { return std::max(own_, rig_.now().since_start); }
  void pass(Duration time_waited) { own_ = time() + time_waited; }

 private:
  const Clock& rig_;
  Duration own_{Duration::min()};
};

}  // namespace gyrotherm::faults
