// SPDX-License-Identifier: Apache-2.0
/// Profiles for the laws of the sequencer.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "sequencer/profile/profile.hpp"

namespace gyrotherm::profile {

/// A profile of these segments, with the three lines every profile begins with: the segments' first line is line 4.
inline std::string with_head(const std::string& segments) {
  return "schema = \"gyrotherm-profile/1\"\nname = \"p\"\n\n" + segments;
}

/// Parses what must be right.
inline Profile parsed(const std::string& segments) {
  auto profile = parse_profile(with_head(segments), "p.toml");
  EXPECT_TRUE(profile.has_value()) << (profile ? "" : text(profile.error()));
  return profile ? *profile : Profile{};
}

/// What is said of a profile with mistakes: "place: what", one a line.
inline std::string refusal(const std::string& segments) {
  const auto profile = parse_profile(with_head(segments), "p.toml");
  return profile ? "nothing" : text(profile.error());
}

inline const std::string kHold20 = "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"100 s\"\n";

}  // namespace gyrotherm::profile
