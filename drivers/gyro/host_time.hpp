// SPDX-License-Identifier: Apache-2.0
/// What the host's clock says of the time that a gyro's frames cover: that time itself where the gyro has no clock, and
/// whether the gyro's own, its stamps or its frames at the described rate, passes as fast. An instant is when bytes
/// came, on any clock that runs evenly.
#pragma once

#include <cstdint>
#include <optional>

#include "core/quantity.hpp"

namespace gyrotherm::drivers {

/// The intervals of a gyro without a clock.
///
/// A line holds frames back, an adapter for USB for up to 16 ms, each time differently: the difference of two instants
/// a second apart is wrong by per cents. Frames that come at a rate of their own tell time better, at the rate that the
/// host sees; the nominal one is 2 to 3 % off from unit to unit of some gyros. So a straight line goes through the
/// instants over the rounds of frames, and what is older than a minute is forgotten: a g-h filter whose memory grows,
/// then fades (Brookner, Tracking and Kalman Filtering Made Easy, 1998, chapter 1). The intervals add up to the host's
/// time.
class HostInterval {
 public:
  /// `even`: the frames come at a rate of their own, whatever it is. Otherwise nothing is smoothed.
  explicit HostInterval(bool even) : even_(even) {}
  /// The next interval begins with a round that came at `came`; what is known of the rate is kept.
  void count_from(Duration came);
  /// From where the next interval begins to `came`, as the host saw it.
  [[nodiscard]] Duration passed(Duration came) const { return came - newest_; }
  /// The interval of the next `rounds`, at least one, of which the newest came at `came`. Nothing if no time has
  /// passed, or if as many take another time, by 0.2 s and half a round: some were lost, or came late, and neither can
  /// be told from the other.
  [[nodiscard]] std::optional<Duration> next(std::uint64_t rounds, Duration came);

 private:
  bool even_;
  int instants_{};     ///< that the line goes through, less those that are forgotten
  Duration newest_{};  ///< the newest round, on the line
  double round_ns_{};
};

/// Whether a gyro's time passes as fast as the host's: a description with another unit, or another rate, makes every
/// rate of rotation wrong by as much.
class FramePace {
 public:
  /// `rate_hz`: how many frames come in a second; 0 where nobody knows, which is one at least.
  explicit FramePace(double rate_hz) : frame_s_(rate_hz > 0 ? 1 / rate_hz : 1) {}
  /// Forgets what was before the frame that came at `came`. What comes next is not judged: a line may have held back
  /// much of it.
  void count_from(Duration came);
  /// The frames since the last call say that `counted` has passed; the newest came at `came`.
  void add(Duration counted, Duration came);
  /// How much of the gyro's time passes in a second of the host's, s. Nothing while that is a second: over the last
  /// half a minute both times agree within 5 % and 0.3 s and a frame, or did so one call before and are not half as far
  /// apart as the host's is long.
  [[nodiscard]] std::optional<double> other_pace() const;

 private:
  double frame_s_;
  Duration newest_{};
  bool judges_{};
  double host_s_{}, counted_s_{};  ///< sums that fade
  int wrong_{};                    ///< calls in a row; one that is far off counts as two
};

}  // namespace gyrotherm::drivers
