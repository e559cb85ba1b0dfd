// SPDX-License-Identifier: Apache-2.0
/// From the profile as written to the flat list of holds and ramps that runs; a random program is drawn on the way, the
/// same one from the same seed on every machine.
#pragma once

#include <vector>

#include "sequencer/profile/profile.hpp"
#include "sequencer/profile/written_profile.hpp"

namespace gyrotherm::profile {

inline constexpr int kMostSegments = 20'000;
inline constexpr Duration kLongestProfile = std::chrono::seconds(100'000'000);

/// Appends the segments of `written` to the profile, and the cycles they make. Mistakes that only the expansion shows
/// (a ramp that goes nowhere, a profile beyond the limits above) are noted in the tables; expansion ends at a limit.
void expand(const std::vector<WrittenSegment>& written, Profile& profile);

}  // namespace gyrotherm::profile
