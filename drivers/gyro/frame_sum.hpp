// SPDX-License-Identifier: Apache-2.0
/// Evaluation of the frames of one interval. For each axis, it adds increments, averages rates, and forms the
/// differences of counts and angles, which may wrap. It also counts lost frames and averages housekeeping values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/quantity.hpp"
#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

/// Returns the arc seconds per count of an axis: the scale of an integer field that has an angle unit, or 1e-6 for a
/// rate or a real number. Returns nothing for pulses without a unit, whose scale is in the rig file. `axis` is an index
/// into FrameFormat::axes.
[[nodiscard]] std::optional<double> arcsec_per_count(const FrameFormat& format, std::size_t axis);

/// Sums of one axis.
struct AxisTally {
  std::uint64_t frames{};  ///< frames that contain the axis
  std::int64_t counts{};   ///< exact; integer fields only
  double arcsec{};         ///< sum of real angles
  double arcsec_per_s{};   ///< sum over `frames`
};

/// Sums since the previous read. A round is one frame, or the messages that together contain every axis. Only whole
/// rounds are counted, so all axes cover the same interval.
struct FrameTally {
  std::uint64_t rounds{};  ///< not counting the origin
  /// Number of lost frames, computed from jumps of the sequence. Without a sequence, it is computed from jumps of the
  /// device's time and the nominal rate.
  std::uint64_t lost{};
  std::uint64_t bad{};  ///< frames the gyro marked bad
  /// A frame arrived twice, or the sequence went backwards.
  bool is_disordered{};
  /// Duration of all rounds, of the last round and of the longest round, by the device's clock (time or sequence). Zero
  /// if the format has no clock.
  Duration interval{};
  Duration round{};
  Duration longest{};
  std::vector<AxisTally> axes{};  ///< in the order of FrameFormat::axes
};

/// Distinguishes another frame rate from lost frames, by the steps between consecutive frames as multiples of the
/// described step. At another rate, all steps differ by the same factor; if frames are lost, only some steps differ.
class StepWatch {
 public:
  /// `exact` is true for the steps of a sequence, which must be equal. The steps of time stamps may vary by 20 %.
  explicit StepWatch(bool exact) : is_exact_(exact) {}
  void add(double step);
  /// Returns the step if it is constant and differs from the described one. It is constant if the last eight steps
  /// agree, or if there are at least three steps and all agree.
  [[nodiscard]] std::optional<double> find_deviating_step() const;
  /// Returns whether all steps so far agree and differ from the described one.
  [[nodiscard]] bool has_constant_deviation() const {
    return run_length_ > 0 && run_length_ == step_count_ && is_deviating();
  }

 private:
  [[nodiscard]] bool is_deviating() const;

  bool is_exact_;
  double step_{};
  std::uint64_t run_length_{}, step_count_{};
};

class FrameSum {
 public:
  explicit FrameSum(const FrameFormat& format);
  /// Adds a frame. If it completes a round, the sums since the previous round are added to `tally`. The first round is
  /// the origin.
  void add(const GyroFrame& frame, FrameTally& tally);
  /// Discards the incomplete round, after lost or bad frames. Its end is the new origin.
  void drop_round();
  [[nodiscard]] bool has_origin() const { return has_origin_; }
  /// Returns true if the latest count or angle of an axis, from which the next difference is computed, came in a frame
  /// that the gyro marked bad.
  [[nodiscard]] bool has_bad_reference() const;
  /// Returns the steps of the sequence from frame to frame. Without a sequence, returns the steps of the device's time
  /// from round to round.
  [[nodiscard]] const StepWatch& steps() const { return steps_; }
  /// Returns whether the format contains a device clock.
  [[nodiscard]] bool has_clock() const { return clocked_by_sequence_ || time_.has_value(); }
  /// Returns the sum of each axis in counts (see arcsec_per_count()). The mean of a rate is multiplied by `interval`.
  [[nodiscard]] std::vector<std::int64_t> counts(const FrameTally& tally, Duration interval) const;

 private:
  /// Settings of one axis, its latest value, and its sums in the incomplete round.
  struct Axis {
    FieldRole role{};
    bool is_counted{};
    std::uint64_t range{};
    double wraps_at{};
    double arcsec_per_unit{};
    std::optional<std::int64_t> pulses{};
    std::optional<double> angle{};
    /// The latest value came in a frame that the gyro marked bad.
    bool is_bad{};
    AxisTally pending{};
  };
  struct Sequence {
    std::uint64_t range{};
    std::uint64_t step{};
  };
  struct Time {
    std::uint64_t range{};
    double unit_s{};
    bool is_real{};  ///< so of unknown resolution
  };

  static void add_reading(const AxisReading& reading, bool is_bad, Axis& axis);
  void update_losses(std::uint32_t sequence, FrameTally& tally);
  void end_round(FrameTally& tally);
  [[nodiscard]] Duration since_last_round() const;
  [[nodiscard]] bool has_time_per_frame() const;

  std::vector<Axis> axes_;
  std::optional<Sequence> sequence_format_;
  std::optional<Time> time_;
  bool clocked_by_sequence_{};
  double rate_hz_{};
  StepWatch steps_;
  bool has_origin_{};
  /// drop_round() discarded frames of the incomplete round.
  bool is_round_dropped_{};
  /// Values of the latest frame.
  std::optional<std::uint32_t> sequence_{};
  std::optional<std::uint64_t> timestamp_{};
  /// A timestamp arrived since the latest round.
  bool has_new_time_{};
  /// Values of the latest round.
  std::optional<std::uint32_t> round_sequence_{};
  std::optional<std::uint64_t> round_timestamp_{};
};

/// Averages the housekeeping of the frames of one read. Each value is averaged over the frames that contain it.
class FrameMeans {
 public:
  explicit FrameMeans(const FrameFormat& format) : sums_(format.values().size()) {}
  /// Adds a frame. A frame that the gyro marks as bad is not averaged, but is counted if it is flagged.
  void add(const GyroFrame& frame);
  /// Returns the means (NaN if no frame had the value), the number of averaged frames and the number of flagged frames,
  /// in the order of list_housekeeping(). Returns an empty list if the format has no housekeeping.
  [[nodiscard]] std::vector<double> values() const;
  /// Discards all frames.
  void clear();

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
