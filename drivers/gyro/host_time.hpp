// SPDX-License-Identifier: Apache-2.0
/// Comparison of a gyro's time with the host's clock: the interval of a gyro without a clock, and the pace of a gyro's
/// own clock (its time stamps, or its frames at the described rate). Instants are arrival times of bytes, on any
/// uniform clock.
#pragma once

#include <cstdint>
#include <optional>

#include "core/quantity.hpp"

namespace gyrotherm::drivers {

/// Intervals of a gyro without a clock.
///
/// A line delays frames irregularly, a USB adapter by up to 16 ms, so that the difference of two arrival times a second
/// apart is wrong by per cents. Frames with a regular rate measure time better, at the rate that the host observes; the
/// nominal rate of some gyros is wrong by 2 to 3 % from unit to unit. Therefore a straight line is fitted to the
/// arrival times over the rounds of frames, with a memory of one minute: a g-h filter with growing, then fading memory
/// (Brookner, Tracking and Kalman Filtering Made Easy, 1998, chapter 1). The sum of the intervals equals the host's
/// time.
class HostInterval {
 public:
  /// Smooths the intervals if the frames have a regular rate, of any value (`even`).
  explicit HostInterval(bool even) : even_(even) {}
  /// Starts the next interval at a round that arrived at `came`. The estimated rate is kept.
  void count_from(Duration came);
  /// Returns the time from the start of the next interval to `came`, by the host's clock.
  [[nodiscard]] Duration passed(Duration came) const { return came - newest_; }
  /// Returns the interval of the next `rounds`, at least one, the newest of which arrived at `came`. Returns nothing if
  /// no time has passed, or if the time differs from the expected one by more than 0.2 s plus half a round: frames were
  /// lost or late, and the two cannot be distinguished.
  [[nodiscard]] std::optional<Duration> next(std::uint64_t rounds, Duration came);

 private:
  bool even_;
  /// Number of arrival times in the fit.
  int instants_{};
  /// Newest round on the fitted line.
  Duration newest_{};
  double round_ns_{};
};

/// Detects a gyro with a time that does not pass as fast as the host's. A description with another unit or rate makes
/// every rotation rate wrong by the same factor.
class FramePace {
 public:
  /// `rate_hz` is the frame rate; 0 means unknown, at least one frame per second.
  explicit FramePace(double rate_hz) : frame_s_(rate_hz > 0 ? 1 / rate_hz : 1) {}
  /// Discards all times before the frame that arrived at `came`. The next call of add() is not judged, because a line
  /// may have delayed many of its frames.
  void count_from(Duration came);
  /// Adds `counted`, the gyro's time of the frames since the last call; the newest arrived at `came`.
  void add(Duration counted, Duration came);
  /// Returns the gyro's time per second of the host's time, s. Returns nothing while both agree: over the last half
  /// minute within 5 % plus 0.3 s plus one frame. A single disagreement of less than half the host's time is tolerated.
  [[nodiscard]] std::optional<double> other_pace() const;

 private:
  double frame_s_;
  Duration newest_{};
  bool judges_{};
  double host_s_{}, counted_s_{};  ///< sums with fading memory
  /// Disagreeing calls in a row; a large disagreement counts twice.
  int wrong_{};
};

}  // namespace gyrotherm::drivers
