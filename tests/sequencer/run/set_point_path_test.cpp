// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/set_point_path.hpp"

#include <gtest/gtest.h>

#include "sequencer/profile/profile.hpp"

namespace gyrotherm::run {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

profile::Profile profile_with(const std::string& segments) {
  const auto profile = profile::parse_profile("schema = \"gyrotherm-profile/1\"\nname = \"p\"\n" + segments, "p.toml");
  EXPECT_TRUE(profile) << text(profile.error());
  return profile.value_or(profile::Profile{});
}

constexpr const char* kRamp =
    "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"5 s\"\n"
    "[[segment]]\nkind = \"ramp\"\nto = 22\nrate = 2\n"
    "[[segment]]\nkind = \"hold\"\nat = 22\ntime = \"5 s\"\n";

TEST(SetPointPath, CountsOneSetPointPerSecondOfRamp) {
  const profile::ChamberLimits limits;
  EXPECT_EQ(count_set_points(profile_with(kRamp), limits, {}), 61);
  EXPECT_EQ(count_set_points(profile_with(kRamp), limits, milliseconds(500)), 61) << "a tick sends one at most";
  EXPECT_EQ(count_set_points(profile_with(kRamp), limits, seconds(10)), 7);
  EXPECT_EQ(count_set_points(profile_with(kRamp), limits, seconds(7)), 10) << "the last one is sent early";
}

TEST(SetPointPath, CountsOneSetPointWithoutRamps) {
  const auto hold = profile_with("[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"8 h\"\n");
  EXPECT_EQ(count_set_points(hold, {}, {}), 1);
}

TEST(SetPointPath, CountsWayToHoldAtChamberRate) {
  profile::ChamberLimits limits;
  limits.fastest_heating = {5};
  limits.fastest_cooling = {2};
  const auto soaks = profile_with(
      "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"1 h\"\n"
      "[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"1 h\"\nguaranteed_soak = true\nsoak_band = \"2 K\"\n"
      "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"1 h\"\nguaranteed_soak = true\nsoak_band = \"2 K\"\n");
  EXPECT_EQ(count_set_points(soaks, limits, {}), 1 + 120 + 300);
  EXPECT_EQ(count_set_points(soaks, limits, seconds(60)), 1 + 2 + 5);
}

TEST(SetPointPath, CountsEveryPassOfRepeat) {
  const auto repeated = profile_with(
      "[[segment]]\nkind = \"hold\"\nat = 20\ntime = \"10 s\"\n"
      "[[segment]]\nkind = \"repeat\"\ncount = 3\n"
      "[[segment.segment]]\nkind = \"ramp\"\nto = 25\nrate = 5\n"
      "[[segment.segment]]\nkind = \"ramp\"\nto = 20\nrate = 5\n");
  EXPECT_EQ(count_set_points(repeated, {}, {}), 1 + 3 * 2 * 60);
}

}  // namespace
}  // namespace gyrotherm::run
