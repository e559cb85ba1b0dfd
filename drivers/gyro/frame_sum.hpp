// SPDX-License-Identifier: Apache-2.0
/// Frames added up to one interval: increments summed (never thinned out), the mean of rates, the wrapped difference of
/// counts and angles; with what the interval lacks.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "core/quantity.hpp"
#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

/// What one count of the sum is, arcsec: the scale of an integer field in an angle's unit; 1e-6 for a rate or a real
/// number. Nothing for plain pulses, whose weight the rig file has.
[[nodiscard]] std::optional<double> arcsec_per_count(const FrameFormat& format);

/// What was seen since the last read.
struct FrameTally {
  std::uint64_t frames{};  ///< with the gyro's field, after the first one ever
  std::uint64_t lost{};  ///< by a jump of the sequence; without one, by a jump of the device's time at the nominal rate
  std::uint64_t bad{};   ///< marked so by the gyro
  Duration interval{};   ///< by the device's clock (time or sequence); zero if the format has none
  Duration frame{};      ///< between the last two frames, likewise
  std::int64_t counts{};  ///< exact, of integer fields
  double arcsec{};        ///< of real angles
  double arcsec_per_s{};  ///< sum of rates, over `frames` of them
};

class FrameSum {
 public:
  explicit FrameSum(FrameFormat format) : format_(std::move(format)) {}
  /// Adds what lies between the newest frame and this one, which becomes the newest. The first one is the origin.
  void add(const GyroFrame& frame, FrameTally& tally);
  [[nodiscard]] bool has_origin() const { return origin_; }
  /// The format has a clock of the device's own.
  [[nodiscard]] bool has_clock() const { return format_.clocked_by_sequence || format_.find(FieldRole::timestamp); }
  /// The sum in counts (see arcsec_per_count) over `interval`, which a rate needs.
  [[nodiscard]] std::int64_t counts(const FrameTally& tally, Duration interval) const;

 private:
  void add_gyro(const GyroFrame& frame, FrameTally& tally);
  [[nodiscard]] std::uint64_t frames_since(std::uint32_t sequence) const;

  FrameFormat format_;
  bool origin_{};
  std::optional<std::uint32_t> sequence_{};
  std::optional<std::uint32_t> gyro_sequence_{};  ///< of the newest frame with the gyro's field
  std::optional<std::uint64_t> timestamp_{};
  std::optional<std::int64_t> pulses_{};
  std::optional<double> angle_{};
};

}  // namespace gyrotherm::drivers
