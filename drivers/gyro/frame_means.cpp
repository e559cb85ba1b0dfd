// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_means.hpp"

#include <algorithm>
#include <limits>

namespace gyrotherm::drivers {

void FrameMeans::add(const GyroFrame& frame) {
  flagged_ += frame.flagged ? 1 : 0;
  if (!frame.good) return;
  bool averaged = false;
  for (std::size_t i = 0; i < std::min(sums_.size(), frame.values.size()); ++i) {
    if (!frame.values[i]) continue;
    sums_[i].sum += *frame.values[i];
    ++sums_[i].frames;
    averaged = true;
  }
  frames_ += averaged ? 1 : 0;
}

std::vector<double> FrameMeans::values() const {
  if (sums_.empty()) return {};
  std::vector<double> found;
  found.reserve(sums_.size() + 2);
  for (const auto& [sum, frames] : sums_)
    found.push_back(frames == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(frames));
  found.push_back(static_cast<double>(frames_));
  found.push_back(static_cast<double>(flagged_));
  return found;
}

void FrameMeans::begin() {
  std::fill(sums_.begin(), sums_.end(), Sum{});
  frames_ = flagged_ = 0;
}

}  // namespace gyrotherm::drivers
