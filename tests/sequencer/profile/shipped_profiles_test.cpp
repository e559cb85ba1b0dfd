// SPDX-License-Identifier: Apache-2.0
/// Every experiment in profiles/ parses, suits an ordinary chamber, and runs to its end.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "sequencer/profile/machine.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "tests/sequencer/profile/profiles.hpp"

namespace gyrotherm::profile {
namespace {

using std::chrono::hours;
using std::chrono::seconds;

namespace fs = std::filesystem;

constexpr ChamberLimits kShippedFor{Celsius{-45}, Celsius{70}, CelsiusPerMinute{6}, CelsiusPerMinute{6}};
const fs::path kProfiles = fs::path(GYROTHERM_SOURCE_DIR) / "profiles";

Profile parse_shipped(const fs::path& path) {
  const auto text = read_text_file(path.string());
  const auto profile = parse_profile(text.value(), path.string());
  EXPECT_TRUE(profile.has_value()) << (profile ? "" : gyrotherm::text(profile.error()));
  return profile.value();
}

/// Air that follows the set point with a time constant of two minutes.
class LaggingAir {
 public:
  Celsius step(Celsius set_point) { return air_ = air_ + (set_point - air_) * (1.0 / 120); }

 private:
  Celsius air_{20};
};

struct Run {
  std::int64_t steps{};
  Phase ended{};
};

Run run(const Profile& profile) {
  LaggingAir air;
  Run run;
  auto state = begin(profile);
  for (; run.steps < 1'000'000; ++run.steps) {
    run.ended = profile_position(profile, state).phase;
    if (run.ended == Phase::complete || run.ended == Phase::overdue) break;
    state = next(profile, state, {seconds(1), air.step(demanded_set_point(profile, state))});
  }
  return run;
}

TEST(ShippedProfiles, ParseFitChamberAndRunToEnd) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kProfiles)) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path());
    auto profile = parse_shipped(entry.path());
    EXPECT_TRUE(check_profile(profile, kShippedFor).has_value());
    if (const auto until = profile.until) {
      for (const auto& block : until->blocks) EXPECT_TRUE(add_block(profile, block.name));
      EXPECT_TRUE(add_block(profile, ""));
    }
    EXPECT_EQ(run(profile).ended, Phase::complete);
    EXPECT_EQ(profile.name, entry.path().stem());
    ++count;
  }
  EXPECT_GE(count, 6);
}

/// The numbers come from the errata, section 5.
TEST(Qualification, MatchesArithmeticOfPaper) {
  const auto profile = parse_shipped(kProfiles / "qualification.toml");
  const auto timeline = plan(profile);
  EXPECT_EQ(profile.segments.size(), 44u);
  EXPECT_EQ(profile.cycles, (std::vector<std::string>{"1 °C/min", "2 °C/min", "3 °C/min", "5 °C/min"}));
  const std::vector<std::pair<int, int>> expected{{67'200, 672}, {55'200, 552}, {51'200, 512}, {48'000, 480}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(timeline.cycles[i].ramps + timeline.cycles[i].holds, seconds(expected[i].first));
    EXPECT_EQ(timeline.cycles[i].holds, seconds(43'200));
    EXPECT_EQ(timeline.cycles[i].clusters, expected[i].second);
  }
  EXPECT_EQ(timeline.all.ramps, seconds(48'800));
  EXPECT_EQ(timeline.all.holds, seconds(172'800));
  EXPECT_EQ(timeline.all.clusters, 2216);
  EXPECT_EQ(run(profile).steps, 221'600);
}

TEST(Qualification, RampTimesMatchErrata) {
  const auto profile = parse_shipped(kProfiles / "qualification.toml");
  const std::vector<int> expected{3600, 6000, 6000, 6000, 2400, 1800, 3000, 3000, 3000, 1200,
                                  1200, 2000, 2000, 2000, 800,  720,  1200, 1200, 1200, 480};
  std::vector<int> ramps;
  for (const auto& s : profile.segments)
    if (s.kind == SegmentKind::ramp) ramps.push_back(static_cast<int>(s.duration / seconds(1)));
  EXPECT_EQ(ramps, expected);
}

TEST(Qualification, WithSoaksHasSameSegmentsAndTakesLonger) {
  const auto timed = parse_shipped(kProfiles / "qualification.toml");
  const auto soaked = parse_shipped(kProfiles / "qualification-soaked.toml");
  ASSERT_EQ(timed.segments.size(), soaked.segments.size());
  for (std::size_t i = 0; i < timed.segments.size(); ++i) {
    EXPECT_EQ(timed.segments[i].target, soaked.segments[i].target);
    EXPECT_EQ(timed.segments[i].duration, shortest(soaked.segments[i]));
    EXPECT_EQ(soaked.segments[i].guaranteed_soak, soaked.segments[i].kind == SegmentKind::hold);
  }
  EXPECT_GT(run(soaked).steps, 221'600);
}

TEST(Random, TakesFortyHoursAndStartsAtRest) {
  const auto profile = parse_shipped(kProfiles / "random.toml");
  const auto timeline = plan(profile);
  EXPECT_EQ(timeline.all.ramps + timeline.all.holds, seconds(144'000));
  EXPECT_EQ(timeline.all.clusters, 1440);
  EXPECT_EQ(profile.segments[0].target, Celsius{20});
  EXPECT_EQ(profile.segments[0].duration, hours(2));
  EXPECT_EQ(run(profile).steps, 144'000);
}

}  // namespace
}  // namespace gyrotherm::profile
