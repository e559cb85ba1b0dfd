// SPDX-License-Identifier: Apache-2.0
/// Sums of frames over one interval, separately for each axis: sums of increments (all of them), means of rates,
/// wrapped differences of counts and angles. They include the losses of the interval, and the means of the
/// housekeeping.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/quantity.hpp"
#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

/// Returns the arc seconds per count of an axis: the scale of an integer field in an angle's unit, or 1e-6 for a rate
/// or a real number. Returns nothing for plain pulses, whose scale is in the rig file. `axis` is an index into
/// FrameFormat::axes.
[[nodiscard]] std::optional<double> arcsec_per_count(const FrameFormat& format, std::size_t axis);

/// Sums of one axis.
struct AxisTally {
  std::uint64_t frames{};  ///< frames with its field
  std::int64_t counts{};   ///< exact, integer fields only
  double arcsec{};         ///< sum of real angles
  double arcsec_per_s{};   ///< sum over `frames`
};

/// Sums since the last read. A round contains every axis once: it is one frame, or several messages. Only whole rounds
/// are counted, so that all axes cover the same interval.
struct FrameTally {
  std::uint64_t rounds{};  ///< after the first one ever
  /// Lost frames, from a jump of the sequence; without a sequence, from a jump of the device's time at the nominal
  /// rate.
  std::uint64_t lost{};
  std::uint64_t bad{};  ///< frames the gyro marked bad
  /// A frame arrived twice, or the sequence went backwards.
  bool disordered{};
  /// Times by the device's clock (time or sequence); zero if the format has none. Of all rounds, of the last round, and
  /// of the longest round.
  Duration interval{};
  Duration round{};
  Duration longest{};
  std::vector<AxisTally> axes{};  ///< in the order of FrameFormat::axes
};

/// Observes the steps between consecutive frames, as multiples of the described step. A unit with another rate setting
/// makes constant steps; lost frames do not.
class StepWatch {
 public:
  /// Steps of a sequence are `exact` whole numbers; steps of time stamps vary.
  explicit StepWatch(bool exact) : exact_(exact) {}
  void add(double step);
  /// Returns the constant step if it differs from the described one. It is constant if the last eight steps agree, or
  /// if all steps since the first frame agree and there are at least three.
  [[nodiscard]] std::optional<double> other_step() const;
  /// Returns true if every step so far was the same and differed from the described one.
  [[nodiscard]] bool is_always_other() const { return run_ > 0 && run_ == all_ && is_other(); }

 private:
  [[nodiscard]] bool is_other() const;

  bool exact_;
  double step_{};
  std::uint64_t run_{}, all_{};
};

class FrameSum {
 public:
  explicit FrameSum(const FrameFormat& format);
  /// Adds a frame. If it completes a round, the sums since the previous round are added to `tally`. The first round is
  /// the origin.
  void add(const GyroFrame& frame, FrameTally& tally);
  /// Discards the current incomplete round after lost or bad frames. Its end is the new origin.
  void drop_round();
  [[nodiscard]] bool has_origin() const { return origin_; }
  /// Returns the steps of the sequence, or of the device's time without a sequence, of all frames since the origin.
  [[nodiscard]] const StepWatch& steps() const { return steps_; }
  /// Returns whether the format has a clock of the device.
  [[nodiscard]] bool has_clock() const { return clocked_by_sequence_ || time_.has_value(); }
  /// Returns the sum of each axis in counts (see arcsec_per_count()). `interval` is needed for rates.
  [[nodiscard]] std::vector<std::int64_t> counts(const FrameTally& tally, Duration interval) const;

 private:
  /// Summation of one axis, its latest value, and its sums in the incomplete round.
  struct Axis {
    FieldRole role{};
    bool is_counted{};
    std::uint64_t range{};
    double wraps_at{};
    double arcsec_per_unit{};
    std::optional<std::int64_t> pulses{};
    std::optional<double> angle{};
    AxisTally share{};
  };
  struct Sequence {
    std::uint64_t range{};
    std::uint64_t step{};
  };
  struct Time {
    std::uint64_t range{};
    double unit_s{};
    bool is_real{};  ///< unknown resolution
  };

  static void add_reading(const AxisReading& reading, Axis& axis);
  void follow(std::uint32_t sequence, FrameTally& tally);
  void end_round(FrameTally& tally);
  [[nodiscard]] Duration since_last_round() const;
  [[nodiscard]] bool tells_each_frame_by_time() const;

  std::vector<Axis> axes_;
  std::optional<Sequence> sequence_format_;
  std::optional<Time> time_;
  bool clocked_by_sequence_{};
  double rate_hz_{};
  StepWatch steps_;
  bool origin_{};
  /// The incomplete round is discarded at its end.
  bool dropped_{};
  /// Values of the latest frame.
  std::optional<std::uint32_t> sequence_{};
  std::optional<std::uint64_t> timestamp_{};
  /// A timestamp arrived after the latest round.
  bool timed_{};
  /// Values of the latest round.
  std::optional<std::uint32_t> round_sequence_{};
  std::optional<std::uint64_t> round_timestamp_{};
};

/// Averages the housekeeping of the frames of one read. Each value is averaged over the frames that contain it.
class FrameMeans {
 public:
  explicit FrameMeans(const FrameFormat& format) : sums_(format.values().size()) {}
  /// Adds a frame. A frame that the gyro marks as bad is not averaged; it may still count as flagged.
  void add(const GyroFrame& frame);
  /// Returns, in the order of list_housekeeping(), the means (NaN if no frame had the value), the number of averaged
  /// frames, and the number of flagged frames. Empty if the format has no housekeeping.
  [[nodiscard]] std::vector<double> values() const;
  /// Discards all frames.
  void begin();

 private:
  struct Sum {
    double sum{};
    std::uint64_t frames{};
  };
  std::vector<Sum> sums_;
  std::uint64_t frames_{};
  std::uint64_t flagged_{};
};

}  // namespace gyrotherm::drivers
