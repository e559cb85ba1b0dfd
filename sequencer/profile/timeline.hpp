// SPDX-License-Identifier: Apache-2.0
/// The profile laid out in time, as it would run if every soak counted from its first second.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sequencer/profile/profile.hpp"

namespace gyrotherm::profile {

struct PlannedSegment {
  Duration start{};
  Duration duration{};
  Celsius from;
  Celsius to;
};

struct CycleTotal {
  std::string name;
  Duration ramps{};
  Duration holds{};
  std::int64_t clusters{};  ///< whole 100-s clusters
};

struct Timeline {
  std::vector<PlannedSegment> segments;  ///< one per Profile::segments
  std::vector<CycleTotal> cycles;        ///< one per Profile::cycles
  CycleTotal all;
};

[[nodiscard]] Timeline plan(const Profile& profile);

/// The table that `gyrotherm check` prints: each segment with start, duration, from, to, rate; then per cycle and in
/// all.
[[nodiscard]] std::string describe(const Profile& profile, const Timeline& timeline);

}  // namespace gyrotherm::profile
