#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tests/rig/faults/reduction.hpp"
#include "tests/rig/faults/trial.hpp"

namespace gyrotherm {
namespace {

constexpr const char* kHour = "tests/rig/faults/hour.toml";
constexpr const char* kWhole = "profiles/qualification.toml";
constexpr const char* kSoaked = "profiles/qualification-soaked.toml";

const TrialGround& ground_of(const std::string& profile) {
  static std::map<std::string, TrialGround> grounds;
  const auto found = grounds.find(profile);
  return found != grounds.end() ? found->second : grounds.emplace(profile, trial_ground(profile)).first->second;
}

/// Files in memory, where there are any: a trial syncs thousands of times.
std::string folder() { return std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : ::testing::TempDir(); }

TrialSetting setting_of(std::uint64_t seed, Schedule schedule) {
  return {.seed = seed, .schedule = std::move(schedule), .folder = folder(), .sync_every = sync_every(seed)};
}

/// What to do about a failure: `fault_schedules --first SEED --reduce`.
void expect_no_law_broken(const TrialGround& ground, const TrialSetting& setting) {
  const auto report = carry_out(ground, setting);
  for (const auto& violation : report.violations)
    ADD_FAILURE() << ground.profile.name << ", seed " << setting.seed << ": " << violation << "\n"
                  << text(setting.schedule);
}

/// Those of one block of seeds, so that blocks run side by side.
class HourLong : public ::testing::TestWithParam<std::uint64_t> {};
constexpr std::uint64_t kSeedsInABlock = 50;

TEST_P(HourLong, FaultSchedulesBreakNoLaw) {
  const auto& ground = ground_of(kHour);
  const auto options = options_for(ground.profile);
  for (auto seed = GetParam(); seed < GetParam() + kSeedsInABlock; ++seed)
    expect_no_law_broken(ground, setting_of(seed, draw_schedule(seed, options)));
}
INSTANTIATE_TEST_SUITE_P(FaultSchedules, HourLong, ::testing::Values(1, 51, 101, 151, 201, 251));

class Whole : public ::testing::TestWithParam<std::uint64_t> {};
TEST_P(Whole, QualificationsWithFaultsBreakNoLaw) {
  const auto& ground = ground_of(GetParam() % 4 < 2 ? kWhole : kSoaked);
  for (auto seed = GetParam(); seed < GetParam() + 2; ++seed)
    expect_no_law_broken(ground, setting_of(seed, draw_schedule(seed, options_for(ground.profile))));
}
INSTANTIATE_TEST_SUITE_P(FaultSchedules, Whole, ::testing::Values(1, 3, 5, 7, 9));

TEST(FaultSchedules, ThatFailedOnceDoNotFailAgain) {
  std::ifstream file(GYROTHERM_SOURCE_DIR "/tests/rig/faults/regressions.txt");
  ASSERT_TRUE(file);
  TrialSetting setting = setting_of(0, {});
  std::string profile;
  const auto carry_out_what_was_read = [&] {
    if (!profile.empty()) expect_no_law_broken(ground_of(profile), setting);
  };
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') || line.empty()) continue;
    if (const auto mishap = parse_mishap(line)) {
      setting.schedule.push_back(*mishap);
      continue;
    }
    carry_out_what_was_read();
    std::istringstream words(line);
    std::uint64_t seed = 0;
    ASSERT_TRUE(words >> profile >> seed) << line;
    setting = setting_of(seed, {});
  }
  carry_out_what_was_read();
}

TEST(FaultSchedules, WithoutMishapsEverySecondExecutesAndNothingIsAlarmed) {
  for (const std::uint64_t seed : {0U, 1U}) {
    const auto report = carry_out(ground_of(kHour), setting_of(seed, {}));
    EXPECT_TRUE(report.violations.empty()) << report.violations.front();
    EXPECT_EQ(report.ending, Ending::complete);
    EXPECT_EQ(report.seconds_in_state[static_cast<std::size_t>(RunState::execute)],
              static_cast<std::int64_t>(report.rows.size()));
  }
}

TEST(FaultSchedules, OfOneSeedGiveOneLog) {
  const auto& ground = ground_of(kHour);
  std::set<std::uint64_t> logs;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto setting = setting_of(seed, draw_schedule(seed, options_for(ground.profile)));
    const auto first = carry_out(ground, setting);
    EXPECT_EQ(first.log_hash, carry_out(ground, setting).log_hash) << "seed " << seed;
    logs.insert(first.log_hash);
  }
  EXPECT_EQ(logs.size(), 12U) << "and other seeds other logs";
}

TEST(FaultSchedules, DrawEveryKindOfMishapAndReachEveryState) {
  const auto options = options_for(ground_of(kHour).profile);
  std::map<MishapKind, int> drawn;
  for (std::uint64_t seed = 1; seed <= 300; ++seed)
    for (const auto& mishap : draw_schedule(seed, options)) ++drawn[mishap.kind];
  for (std::size_t kind = 0; kind < kMishapKinds; ++kind)
    EXPECT_GE(drawn[static_cast<MishapKind>(kind)], 3) << name(static_cast<MishapKind>(kind));
  std::array<std::int64_t, 7> seconds{};
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const auto report = carry_out(ground_of(kHour), setting_of(seed, draw_schedule(seed, options)));
    for (std::size_t i = 0; i < seconds.size(); ++i) seconds[i] += report.seconds_in_state[i];
  }
  for (const auto state : {RunState::execute, RunState::suspended, RunState::held, RunState::aborting})
    EXPECT_GT(seconds[static_cast<std::size_t>(state)], 0) << name(state);
}

TEST(FaultSchedules, AreReadAsTheyAreWritten) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed)
    for (const auto& mishap : draw_schedule(seed, {})) EXPECT_EQ(parse_mishap(text(mishap)), mishap) << text(mishap);
  EXPECT_FALSE(parse_mishap("12 nothing_like_it 0 1 0"));
}

/// How many rows each segment has.
std::map<int, std::int64_t> rows_by_segment(const TrialReport& report) {
  std::map<int, std::int64_t> rows;
  for (const auto& row : report.rows) ++rows[row.segment];
  return rows;
}

/// A crash just before a segment begins, and just after.
void expect_resume_equals_twin(const std::string& profile, std::int64_t down) {
  const auto& ground = ground_of(profile);
  auto setting = setting_of(2, {});
  setting.sync_every = 1;
  const auto twin = carry_out(ground, setting);
  ASSERT_EQ(twin.ending, Ending::complete);
  const auto rows_of_twin = rows_by_segment(twin);
  for (std::size_t i = 1; i < twin.rows.size(); ++i) {
    if (twin.rows[i].segment == twin.rows[i - 1].segment) continue;
    for (const std::int64_t offset : {0, 1}) {
      const auto at = twin.rows[i].slot + offset;
      setting.schedule = {{.at = at, .kind = MishapKind::program_crashes, .target = 0, .lasts = down, .size = 0}};
      const auto report = carry_out(ground, setting);
      const auto where = ::testing::Message() << "crash at second " << at;
      EXPECT_TRUE(report.violations.empty()) << where << ": " << report.violations.front();
      ASSERT_EQ(report.ending, Ending::complete) << where;
      EXPECT_EQ(report.lives, 2) << where;
      const auto rows = rows_by_segment(report);
      ASSERT_EQ(rows.size(), rows_of_twin.size()) << where;
      for (const auto& [segment, count] : rows_of_twin)
        EXPECT_GE(rows.at(segment), count) << where << ": segment " << segment + 1 << " was cut short";
    }
  }
}

TEST(Crash, AtAnySegmentsBoundaryIsFollowedByTheSameSegmentsNoneOfThemShorter) { expect_resume_equals_twin(kHour, 30); }

}  // namespace
}  // namespace gyrotherm
