// SPDX-License-Identifier: Apache-2.0
/// Evaluation of the frames of one interval. For each axis, increments are added, rates are averaged, and differences
/// of counts and angles are formed across their wraps. Lost frames are counted, and housekeeping values are averaged.
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

/// Sums since the last read. A round is one frame, or the messages that together contain every axis. Only whole rounds
/// are counted, so that all axes cover the same interval.
struct FrameTally {
  std::uint64_t rounds{};  ///< after the first one ever
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

/// Observes the steps between consecutive frames, as multiples of the described step. If a unit is set to another rate,
/// all steps differ by the same factor; if frames are lost, only some steps differ.
class StepWatch {
 public:
  /// `exact` selects the comparison of steps: those of a sequence must be equal, those of time stamps may vary by 20 %.
  explicit StepWatch(bool exact) : is_exact_(exact) {}
  void add(double step);
  /// Returns the constant step if it differs from the described one. It is constant if the last eight steps agree, or
  /// if all steps since the first frame agree and there are at least three.
  [[nodiscard]] std::optional<double> find_deviating_step() const;
  /// Returns true if every step so far was the same and differed from the described one.
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
  /// Discards the incomplete round after lost or bad frames. The end of this round is the new origin.
  void drop_round();
  [[nodiscard]] bool has_origin() const { return has_origin_; }
  /// Returns the steps of the sequence between the frames so far. Without a sequence, returns the steps of the device's
  /// time between rounds.
  [[nodiscard]] const StepWatch& steps() const { return steps_; }
  /// Returns whether the format contains a device clock.
  [[nodiscard]] bool has_clock() const { return clocked_by_sequence_ || time_.has_value(); }
  /// Returns the sum of each axis in counts (see arcsec_per_count()). `interval` is needed for rates.
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
    AxisTally pending{};
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
  /// The incomplete round is discarded at its end.
  bool is_round_dropped_{};
  /// Values of the latest frame.
  std::optional<std::uint32_t> sequence_{};
  std::optional<std::uint64_t> timestamp_{};
  /// A timestamp arrived after the latest round.
  bool has_new_time_{};
  /// Values of the latest round.
  std::optional<std::uint32_t> round_sequence_{};
  std::optional<std::uint64_t> round_timestamp_{};
};

/// Averages the housekeeping of the frames of one read. Each value is averaged over the frames that contain it.
class FrameMeans {
 public:
  explicit FrameMeans(const FrameFormat& format) : sums_(format.values().size()) {}
  /// Adds a frame. A frame that the gyro marks as bad is not averaged, but it may be counted as a flagged frame.
  void add(const GyroFrame& frame);
  /// Returns, in the order of list_housekeeping(), the means (NaN if no frame had the value), the number of averaged
  /// frames, and the number of flagged frames. Empty if the format has no housekeeping.
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
