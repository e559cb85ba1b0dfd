// SPDX-License-Identifier: Apache-2.0
/// The time of one line in memory: who waits on it keeps nobody else waiting, as with a worker of its own.
#pragma once

#include <algorithm>

#include "core/clock.hpp"

namespace gyrotherm::faults {

/// The rig's clock, moved by whoever runs the run; its UTC can be put forward and back.
class SimulatedClock final : public Clock {
 public:
  [[nodiscard]] Instant now() const override { return {elapsed_, kVirtualEpoch + elapsed_ + step_}; }
  void advance(Duration by) { elapsed_ += by; }
  void step_utc(Duration by) { step_ += by; }
  /// What a program that starts now takes for the beginning of its run.
  void restart_at(Duration elapsed) { elapsed_ = elapsed; }

 private:
  Duration elapsed_{}, step_{};
};

/// Ahead of the rig's clock by what was waited.
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
