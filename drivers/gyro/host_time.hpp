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
/// A line delays frames irregularly, a USB adapter by up to 16 ms. Therefore the difference of two arrival times a
/// second apart has an error of one or two per cent. Frames that are sent at a regular rate measure time better. The
/// rate must be observed by the host, because the actual rate of some gyros differs from the nominal one by 2 to 3 %,
/// depending on the unit. Therefore a straight line is fitted to the arrival times as a function of the number of
/// rounds, with a memory of one minute: a g-h filter with growing, then fading memory (Brookner, Tracking and Kalman
/// Filtering Made Easy, 1998, chapter 1). The sum of the intervals follows the host's clock.
class HostInterval {
 public:
  /// Smooths the intervals if `even` is true: the frames have a regular rate, which need not be known.
  explicit HostInterval(bool has_regular_rate) : has_regular_rate_(has_regular_rate) {}
  /// Starts the next interval at a round that arrived at `came`. The estimated rate is kept.
  void start_at(Duration arrival);
  /// Returns the time from the start of the next interval to `came`, by the host's clock.
  [[nodiscard]] Duration time_since_start(Duration arrival) const { return arrival - newest_; }
  /// Returns the interval of the next `rounds`, at least one, the newest of which arrived at `came`. Returns nothing if
  /// no time has passed, or if the time differs from the expected one by more than 0.2 s plus half a round. Frames were
  /// then lost or late; these cases cannot be distinguished.
  [[nodiscard]] std::optional<Duration> next(std::uint64_t rounds, Duration arrival);

 private:
  bool has_regular_rate_;
  /// Number of arrival times in the fit.
  int instants_{};
  /// Time of the newest round, on the fitted line.
  Duration newest_{};
  double round_ns_{};
};

/// Detects a gyro whose time passes faster or slower than the host's. The cause is usually a wrong unit of time or
/// frame rate in the description, which makes every rotation rate wrong by the same factor.
class FramePace {
 public:
  /// `rate_hz` is the frame rate; 0 means unknown, at least one frame per second.
  explicit FramePace(double rate_hz) : frame_s_(rate_hz > 0 ? 1 / rate_hz : 1) {}
  /// Discards all times before the frame that arrived at `came`. The next call of add() is not evaluated, because a
  /// line may have delayed many of its frames.
  void start_at(Duration arrival);
  /// Adds `counted`, the gyro's time of the frames since the last call; the newest arrived at `came`.
  void add(Duration gyro_time, Duration arrival);
  /// Returns the gyro's time per second of the host's time, s. Returns nothing while both agree. They agree if they
  /// differ by at most 5 % plus 0.3 s plus one frame, over about the last half minute. A single larger difference is
  /// tolerated if it is at most half the host's time.
  [[nodiscard]] std::optional<double> find_deviating_pace() const;

 private:
  double frame_s_;
  Duration newest_{};
  bool is_started_{};
  double host_s_{}, counted_s_{};  ///< sums with fading memory
  /// Number of calls in a row with a difference; a large difference counts as two.
  int deviations_{};
};

}  // namespace gyrotherm::drivers
