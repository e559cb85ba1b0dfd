// SPDX-License-Identifier: Apache-2.0
/// What a gyro tells of itself, averaged over the frames of one reading.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

/// The means of a format's housekeeping. Not all frames need carry all values: each is averaged over those that do.
class FrameMeans {
 public:
  explicit FrameMeans(const FrameFormat& format) : sums_(format.values().size()) {}
  /// A frame that the gyro marks as bad is counted if its status says so, but not averaged.
  void add(const GyroFrame& frame);
  /// In the order of housekeeping_of(): the means, NaN where no frame had the value; the number of frames that were
  /// averaged; the number of frames that were flagged. Nothing at all if the format has no housekeeping.
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
