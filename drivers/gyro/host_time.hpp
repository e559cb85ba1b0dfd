// SPDX-License-Identifier: Apache-2.0
/// Comparison of a gyro's time with the host's clock: the interval of a gyro without a clock, and the pace of a gyro's
/// own clock (its time stamps, or its frames at the described rate). Instants are arrival times of bytes, on any
/// uniform clock.
#pragma once

#include <cstdint>
#include <optional>

#include "core/quantity.hpp"

namespace gyrotherm::drivers {

/// Measures the intervals of a gyro without a clock.
///
/// A line delays frames irregularly, a USB adapter by up to 16 ms, so the difference of two arrival times one second
/// apart has an error of one or two per cent. The frames themselves measure time better if their rate is regular. The
/// host must observe this rate, because the actual rate of some gyros differs from the nominal one by 2 to 3 %,
/// depending on the unit. Therefore a straight line is fitted to the arrival times as a function of the number of
/// rounds, with a memory of one minute: a g-h filter with growing, then fading memory (Brookner, Tracking and Kalman
/// Filtering Made Easy, 1998, chapter 1). The sum of the intervals follows the host's clock.
class HostInterval {
 public:
  /// Smooths the intervals if the frames have a regular rate, which need not be known.
  explicit HostInterval(bool has_regular_rate) : has_regular_rate_(has_regular_rate) {}
  /// Starts the next interval at a round that arrived at `arrival`. Keeps the estimated rate.
  void start_at(Duration arrival);
  /// Returns the time from the start of the next interval to `arrival`, by the host's clock.
  [[nodiscard]] Duration time_since_start(Duration arrival) const { return arrival - newest_; }
  /// Returns the interval of the next `rounds`, at least one, the newest of which arrived at `arrival`. Returns nothing
  /// if no time has passed, or if the time differs from the expected one by more than 0.2 s plus half a round. Frames
  /// were then lost or late; the two cases cannot be distinguished.
  [[nodiscard]] std::optional<Duration> next(std::uint64_t rounds, Duration arrival);

 private:
  bool has_regular_rate_;
  /// Number of arrival times in the fit.
  int instants_{};
  /// Time of the newest round, on the fitted line.
  Duration newest_{};
  double round_ns_{};  ///< estimated duration of a round
};

/// Detects a gyro whose time passes faster or slower than the host's. The cause is usually a wrong unit of time or
/// frame rate in the description, which makes every rotation rate wrong by the same factor.
class FramePace {
 public:
  /// `rate_hz` is the frame rate; 0 means unknown, but at least one frame per second.
  explicit FramePace(double rate_hz) : frame_s_(rate_hz > 0 ? 1 / rate_hz : 1) {}
  /// Discards all times before the frame that arrived at `arrival`. The next call of add() only sets the start of the
  /// comparison, because the line may have delayed many of its frames.
  void start_at(Duration arrival);
  /// Adds the duration of the frames since the last call by the gyro's clock. The newest frame arrived at `arrival`.
  void add(Duration gyro_time, Duration arrival);
  /// Returns the gyro's time divided by the host's time, over about the last 30 s, or nothing if the two agree. They
  /// agree if they differ by at most 5 % of the host's time plus 0.3 s plus one frame. The function also returns
  /// nothing after a single call of add() with a larger difference, unless it exceeds half of the host's time.
  [[nodiscard]] std::optional<double> find_deviating_pace() const;

 private:
  double frame_s_;
  Duration newest_{};
  bool is_started_{};           ///< add() was called since start_at()
  double host_s_{}, gyro_s_{};  ///< sums with fading memory
  /// Number of consecutive calls of add() after which the times do not agree; a difference of more than half of the
  /// host's time counts as two calls.
  int deviations_{};
};

}  // namespace gyrotherm::drivers
