// SPDX-License-Identifier: Apache-2.0
/// Frames added up to one interval, each axis for itself: increments summed (never thinned out), the mean of rates, the
/// wrapped difference of counts and angles; with what the interval lacks. And the means of their housekeeping.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/quantity.hpp"
#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

/// What one count of the sum of an axis is, arcsec: the scale of an integer field in an angle's unit; 1e-6 for a rate
/// or a real number. Nothing for plain pulses, whose weight the rig file has. `axis`: an index of FrameFormat::axes.
[[nodiscard]] std::optional<double> arcsec_per_count(const FrameFormat& format, std::size_t axis);

/// What was seen of one axis.
struct AxisTally {
  std::uint64_t frames{};  ///< with its field
  std::int64_t counts{};   ///< exact, of integer fields
  double arcsec{};         ///< of real angles
  double arcsec_per_s{};   ///< sum of rates, over `frames` of them
};

/// What was seen since the last read. A round is what brings every axis once: a frame, if one frame has all axes, or as
/// many messages as it takes. Axes count in whole rounds, so that all of them cover the same interval.
struct FrameTally {
  std::uint64_t rounds{};  ///< after the first one ever
  std::uint64_t lost{};    ///< frames, by a jump of the sequence; without one, by a jump of the device's time at the
                           ///< nominal rate
  std::uint64_t bad{};     ///< frames marked so by the gyro
  bool disordered{};       ///< a frame came twice, or the sequence went back
  Duration interval{};     ///< by the device's clock (time or sequence); zero if the format has none
  Duration round{};        ///< between the last two rounds, likewise
  Duration longest{};      ///< of all that lies between two rounds, likewise
  std::vector<AxisTally> axes{};  ///< in the order of FrameFormat::axes
};

/// Watches the steps from each frame to the next, as multiples of the described one. A unit that is set to another
/// rate makes steps that are all the same; lost frames do not.
class StepWatch {
 public:
  /// `exact`: steps of a sequence, which are whole numbers; stamps of time scatter.
  explicit StepWatch(bool exact) : exact_(exact) {}
  void add(double step);
  /// Returns the steady step if it is not the described one: the last eight agree, or all since the first frame do and
  /// there are three.
  [[nodiscard]] std::optional<double> other_step() const;
  /// True if every step so far was the same and was not the described one.
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
  /// Adds what lies between the newest round and this frame, once the frame ends a round, which becomes the newest. The
  /// first one is the origin.
  void add(const GyroFrame& frame, FrameTally& tally);
  /// What has come since the last whole round is not trusted, as frames were lost or bad: the round that it belongs to
  /// counts for nothing but to count from.
  void drop_round();
  [[nodiscard]] bool has_origin() const { return origin_; }
  /// The steps of the sequence, or without one of the device's time, of all frames since the origin.
  [[nodiscard]] const StepWatch& steps() const { return steps_; }
  /// The format has a clock of the device's own.
  [[nodiscard]] bool has_clock() const { return clocked_by_sequence_ || time_.has_value(); }
  /// The sum of each axis in counts (see arcsec_per_count) over `interval`, which a rate needs.
  [[nodiscard]] std::vector<std::int64_t> counts(const FrameTally& tally, Duration interval) const;

 private:
  /// One axis: how its field is summed, its newest value, and its share of the round that is not whole yet.
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
    bool is_real{};  ///< its resolution is not known
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
  bool dropped_{};                                 ///< the round that is not whole yet
  std::optional<std::uint32_t> sequence_{};        ///< of the newest frame
  std::optional<std::uint64_t> timestamp_{};       ///< the newest
  bool timed_{};                                   ///< it came since the newest round
  std::optional<std::uint32_t> round_sequence_{};  ///< of the newest round
  std::optional<std::uint64_t> round_timestamp_{};
};

/// Averages the housekeeping of the frames of one read. Each value is averaged over the frames that carry it.
class FrameMeans {
 public:
  explicit FrameMeans(const FrameFormat& format) : sums_(format.values().size()) {}
  /// Adds a frame. A frame that the gyro marks as bad is not averaged; it counts as flagged if its status is.
  void add(const GyroFrame& frame);
  /// Returns, in the order of housekeeping_of(): the means, NaN if no frame had the value; the number of averaged
  /// frames; the number of flagged frames. Empty if the format has no housekeeping.
  [[nodiscard]] std::vector<double> values() const;
  /// Forgets all frames.
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
