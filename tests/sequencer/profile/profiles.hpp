// SPDX-License-Identifier: Apache-2.0
/// Profiles for the tests of the sequencer.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "sequencer/profile/profile.hpp"

namespace gyrotherm::profile {

/// Returns a profile of these segments after the three lines of every profile: the segments start at line 4.
inline std::string add_head(const std::string& segments) {
  return "schema = \"gyrotherm-profile/1\"\nname = \"p\"\n\n" + segments;
}

/// Parses a valid profile.
inline Profile parsed(const std::string& segments) {
  auto profile = parse_profile(add_head(segments), "p.toml");
  EXPECT_TRUE(profile.has_value()) << (profile ? "" : text(profile.error()));
  return profile ? *profile : Profile{};
}

/// Returns the errors of a profile: "position: error", one per line.
inline std::string profile_errors(const std::string& segments) {
  const auto profile = parse_profile(add_head(segments), "p.toml");
  return profile ? "nothing" : text(profile.error());
}

inline const std::string kHold20 = "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"100 s\"\n";

}  // namespace gyrotherm::profile
