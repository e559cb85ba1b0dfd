// SPDX-License-Identifier: Apache-2.0
/// Writes segments as the text of a profile. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "sequencer/profile/profile.hpp"

namespace gyrotherm::profile {

/// A segment with the comment above it; empty: none.
struct CommentedSegment {
  Segment segment;
  std::string comment{};
};

struct ProfileText {
  /// Comment at the beginning. Lines are separated by '\n'.
  std::string comment{};
  std::string name;
  std::string title;
  std::vector<CommentedSegment> segments;
};

/// Returns a profile that parse_profile() expands to the same segments: the same kinds, targets, durations, soaks,
/// states of the unit and prompts. Cycles are not written. Comments are reduced to printable characters.
[[nodiscard]] std::string write_profile(const ProfileText& profile);

}  // namespace gyrotherm::profile
