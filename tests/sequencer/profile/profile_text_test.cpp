// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/profile_text.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/file.hpp"

namespace gyrotherm::profile {
namespace {

ProfileText text_of(const Profile& profile) {
  ProfileText text{.comment = "one\ntwo", .name = "written", .title = "A \"quoted\" \\ title", .segments = {}};
  for (const Segment& segment : profile.segments) text.segments.push_back({segment, "a comment"});
  return text;
}

void expect_same(const Profile& read, const Profile& original, const std::string& file) {
  ASSERT_EQ(read.segments.size(), original.segments.size()) << file;
  for (std::size_t i = 0; i < read.segments.size(); ++i) {
    SCOPED_TRACE(file + ", segment " + std::to_string(i + 1));
    const Segment &a = read.segments[i], &b = original.segments[i];
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.target, b.target);
    EXPECT_EQ(a.duration, b.duration);
    EXPECT_EQ(a.deadline, b.deadline);
    EXPECT_NEAR(a.rate.value, b.rate.value, 1e-2);
    EXPECT_EQ(a.guaranteed_soak, b.guaranteed_soak);
    if (b.guaranteed_soak) {
      EXPECT_EQ(a.soak_band, b.soak_band);
      EXPECT_EQ(a.soak_sensor, b.soak_sensor);
      EXPECT_EQ(a.soak_dwell, b.soak_dwell);
      EXPECT_EQ(a.soak_time, b.soak_time);
      EXPECT_EQ(a.soak_slope, b.soak_slope);
    }
    EXPECT_EQ(a.unit.off, b.unit.off);
    EXPECT_EQ(a.unit.turned, b.unit.turned);
    EXPECT_EQ(a.prompt, b.prompt);
    EXPECT_EQ(a.opens_door, b.opens_door);
  }
}

TEST(ProfileText, OfEachShippedProfileHasTheSameSegments) {
  int profiles = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles")) {
    if (entry.path().extension() != ".toml") continue;
    ++profiles;
    const auto original = parse_profile(*read_text_file(entry.path().string()), entry.path().string());
    ASSERT_TRUE(original);
    const auto read = parse_profile(write_profile(text_of(*original)), "written.toml");
    ASSERT_TRUE(read) << text(read.error());
    expect_same(*read, *original, entry.path().filename());
    EXPECT_EQ(read->title, "A \"quoted\" \\ title");
  }
  EXPECT_GE(profiles, 12);
}

TEST(ProfileText, KeepsPromptsDoorsAndSoaks) {
  const auto original = parse_profile(R"(schema = "gyrotherm-profile/1"
name = "p"
[[segment]]
kind = "hold"
at = 20
time = "90 s"
prompt = "Connect the \"second\" cable"
door = "opened"
soak_band = 0.5
soak_sensor = "A"
soak_dwell = "3 min"
soak_slope = 0.1
soak_time = "45 s"
guaranteed_soak = true
deadline = "7 h"
[[segment]]
kind = "ramp"
to = -13.3
time = "1234 s"
[[segment]]
kind = "hold"
time = "1 h"
power = "off"
axis = "turned"
door = "closed"
[[segment]]
kind = "hold"
time = "1 h"
power = "on"
)",
                                      "p.toml");
  ASSERT_TRUE(original) << text(original.error());
  const auto read = parse_profile(write_profile(text_of(*original)), "written.toml");
  ASSERT_TRUE(read) << text(read.error());
  expect_same(*read, *original, "p.toml");
}

TEST(ProfileText, WritesCommentsAsComments) {
  ProfileText text{.comment = "first\n[[segment]]\n\x1b[31mred", .name = "n", .title = "t", .segments = {}};
  text.segments.push_back({{.kind = SegmentKind::hold,
                            .name = "hold",
                            .target = Celsius{20},
                            .duration = kSecond * 60,
                            .deadline = kSecond * 60},
                           "kind = \"ramp\"\nnext"});
  const auto read = parse_profile(write_profile(text), "written.toml");
  ASSERT_TRUE(read) << gyrotherm::text(read.error());
  EXPECT_EQ(read->segments.size(), 1u);
}

}  // namespace
}  // namespace gyrotherm::profile
