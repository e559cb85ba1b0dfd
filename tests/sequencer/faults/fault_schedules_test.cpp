// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tests/sequencer/faults/shrinking.hpp"
#include "tests/sequencer/faults/simulated_run.hpp"

namespace gyrotherm::faults {
namespace {

constexpr const char* kHour = "tests/sequencer/faults/hour.toml";
constexpr const char* kWhole = "profiles/qualification.toml";
constexpr const char* kSoaked = "profiles/qualification-soaked.toml";
constexpr const char* kUntil = "tests/sequencer/faults/until.toml";

const SimulatedSetup& setup_for(const std::string& profile) {
  static std::map<std::string, SimulatedSetup> grounds;
  const auto found = grounds.find(profile);
  return found != grounds.end() ? found->second : grounds.emplace(profile, simulated_setup(profile)).first->second;
}

/// Returns a folder in memory if there is one: a simulated run syncs thousands of times.
std::string folder() { return std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : ::testing::TempDir(); }

SimulatedRunSetting make_setting(std::uint64_t seed, Schedule schedule) {
  return {.seed = seed, .schedule = std::move(schedule), .folder = folder(), .sync_every = sync_every(seed)};
}

/// Fails for each violated invariant. `fault_schedules --first SEED --reduce` reproduces a failure.
void expect_invariants_hold(const SimulatedSetup& ground, const SimulatedRunSetting& setting) {
  const auto report = carry_out(ground, setting);
  for (const auto& violation : report.violations)
    ADD_FAILURE() << ground.profile.name << ", seed " << setting.seed << ": " << violation << "\n"
                  << text(setting.schedule);
}

/// Tests one block of seeds. The blocks can run in parallel.
class HourLong : public ::testing::TestWithParam<std::uint64_t> {};
constexpr std::uint64_t kSeedsInABlock = 50;

TEST_P(HourLong, FaultSchedulesViolateNoInvariant) {
  const auto& ground = setup_for(kHour);
  const auto options = options_for(ground);
  for (auto seed = GetParam(); seed < GetParam() + kSeedsInABlock; ++seed)
    expect_invariants_hold(ground, make_setting(seed, draw_schedule(seed, options)));
}
INSTANTIATE_TEST_SUITE_P(FaultSchedules, HourLong, ::testing::Values(1, 51, 101, 151, 201, 251));

class Whole : public ::testing::TestWithParam<std::uint64_t> {};
TEST_P(Whole, QualificationsWithFaultsViolateNoInvariant) {
  const auto& ground = setup_for(GetParam() % 4 < 2 ? kWhole : kSoaked);
  for (auto seed = GetParam(); seed < GetParam() + 2; ++seed)
    expect_invariants_hold(ground, make_setting(seed, draw_schedule(seed, options_for(ground))));
}
#ifdef GYROTHERM_NIGHTLY
INSTANTIATE_TEST_SUITE_P(FaultSchedules, Whole, ::testing::Values(1, 3, 5, 7, 9));
#else
INSTANTIATE_TEST_SUITE_P(FaultSchedules, Whole, ::testing::Values(1, 7));  // one with each profile
#endif

class SelfEnding : public ::testing::TestWithParam<std::uint64_t> {};
TEST_P(SelfEnding, RunsWithFaultsViolateNoInvariantAndKeepTheirPath) {
  const auto& ground = setup_for(kUntil);
  const auto options = options_for(ground);
  const auto calm = carry_out(ground, make_setting(0, {}));
  ASSERT_EQ(calm.ending, Ending::complete);
  ASSERT_GE(calm.blocks.size(), 5U);
  EXPECT_EQ(calm.blocks.back(), "") << "closing";
  std::size_t longest = 0;
  for (auto seed = GetParam(); seed < GetParam() + kSeedsInABlock; ++seed) {
    const auto setting = make_setting(seed, draw_schedule(seed, options));
    const auto report = carry_out(ground, setting);
    for (const auto& violation : report.violations)
      ADD_FAILURE() << "seed " << seed << ": " << violation << "\n" << text(setting.schedule);
    for (std::size_t i = 0; i < report.blocks.size(); ++i)
      if (!report.blocks[i].empty()) {
        ASSERT_LT(i, calm.blocks.size()) << "seed " << seed;
        EXPECT_EQ(report.blocks[i], calm.blocks[i]) << "seed " << seed << ", block " << i + 1;
      }
    longest = std::max(longest, report.blocks.size());
  }
  EXPECT_GE(longest, calm.blocks.size()) << "some runs reach their end";
}
INSTANTIATE_TEST_SUITE_P(FaultSchedules, SelfEnding, ::testing::Values(1));  // nightly: a thousand

TEST(FaultSchedules, PassWhenTheyFailedOnce) {
  std::ifstream file(GYROTHERM_SOURCE_DIR "/tests/sequencer/faults/regressions.txt");
  ASSERT_TRUE(file);
  SimulatedRunSetting setting = make_setting(0, {});
  std::string profile;
  int carried_out = 0;
  const auto carry_out_what_was_read = [&] {
    if (profile.empty()) return;
    expect_invariants_hold(setup_for(profile), setting);
    ++carried_out;
  };
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') || line.empty()) continue;
    if (const auto fault = parse_fault(line)) {
      setting.schedule.push_back(*fault);
      continue;
    }
    carry_out_what_was_read();
    std::istringstream words(line);
    std::uint64_t seed = 0;
    ASSERT_TRUE(words >> profile >> seed) << line;
    setting = make_setting(seed, {});
  }
  carry_out_what_was_read();
  EXPECT_GT(carried_out, 0);
}

TEST(FaultSchedules, ExecuteEverySecondWithoutAlarmWhenEmpty) {
  for (const std::uint64_t seed : {0U, 1U}) {
    const auto report = carry_out(setup_for(kHour), make_setting(seed, {}));
    EXPECT_TRUE(report.violations.empty()) << report.violations.front();
    EXPECT_EQ(report.ending, Ending::complete);
    EXPECT_EQ(report.seconds_in_state[static_cast<std::size_t>(RunState::execute)],
              static_cast<std::int64_t>(report.rows.size()));
  }
}

TEST(FaultSchedules, GiveSameLogForSameSeed) {
  const auto& ground = setup_for(kHour);
  std::set<std::uint64_t> logs;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto setting = make_setting(seed, draw_schedule(seed, options_for(ground)));
    const auto first = carry_out(ground, setting);
    EXPECT_EQ(first.log_hash, carry_out(ground, setting).log_hash) << "seed " << seed;
    logs.insert(first.log_hash);
  }
  EXPECT_EQ(logs.size(), 12U) << "other seeds give other logs";
}

/// Twenty-four axes on eight lines: one falls silent, is dropped and is returned, and the others continue.
TEST(FaultSchedules, ViolateNoInvariantWithLotOfGyros) {
  const auto lot = simulated_setup(kHour, "virtual-lot");
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    expect_invariants_hold(lot, make_setting(seed, draw_schedule(seed, options_for(lot))));
  const Schedule one_comes_to_grief{{.at = 300, .kind = InjectedFaultKind::gyro_gone, .target = 3, .lasts = 1500},
                                    {.at = 400, .kind = InjectedFaultKind::unit_dropped, .target = 3, .lasts = 2000}};
  const auto report = carry_out(lot, make_setting(7, one_comes_to_grief));
  EXPECT_EQ(report.violations, std::vector<std::string>{});
  EXPECT_EQ(report.ending, Ending::complete);
}

TEST(FaultSchedules, DrawEveryKindOfFaultAndReachEveryState) {
  const auto options = options_for(setup_for(kHour));
  auto of_many_units = options;
  of_many_units.units = 8;
  std::map<InjectedFaultKind, int> drawn;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    for (const auto& fault : draw_schedule(seed, options)) ++drawn[fault.kind];
    for (const auto& fault : draw_schedule(seed, of_many_units))
      if (fault.kind == InjectedFaultKind::unit_dropped) ++drawn[fault.kind];
  }
  for (std::size_t kind = 0; kind < kInjectedFaultKinds; ++kind)
    EXPECT_GE(drawn[static_cast<InjectedFaultKind>(kind)], 3) << name(static_cast<InjectedFaultKind>(kind));
  std::array<std::int64_t, 7> seconds{};
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const auto report = carry_out(setup_for(kHour), make_setting(seed, draw_schedule(seed, options)));
    for (std::size_t i = 0; i < seconds.size(); ++i) seconds[i] += report.seconds_in_state[i];
  }
  for (const auto state : {RunState::execute, RunState::suspended, RunState::held, RunState::aborting})
    EXPECT_GT(seconds[static_cast<std::size_t>(state)], 0) << name(state);
}

/// Runs one schedule for each fault that stops the disk.
TEST(FaultSchedules, SurviveDiskThatAcceptsNothing) {
  const auto with = [](std::uint64_t seed, InjectedFaultKind kind, double size) {
    const Schedule schedule{{.at = 600, .kind = kind, .target = 0, .lasts = 400, .size = size},
                            {.at = 1500, .kind = InjectedFaultKind::power_cut, .target = 0, .lasts = 60, .size = 0}};
    const auto report = carry_out(setup_for(kHour), make_setting(seed, schedule));
    for (const auto& violation : report.violations) ADD_FAILURE() << name(kind) << ": " << violation;
    EXPECT_EQ(report.ending, Ending::complete) << name(kind);
    EXPECT_EQ(report.lives, 2) << name(kind);
    return report;
  };
  for (const auto kind : {InjectedFaultKind::disk_full, InjectedFaultKind::disk_hangs}) {
    const auto report = with(4, kind, 0);
    EXPECT_GE(report.longest_backlog, 390) << name(kind) << ": the disk accepted nothing";
    EXPECT_EQ(report.parts, 1) << name(kind) << ": the file is intact";
  }
  for (const auto kind : {InjectedFaultKind::disk_fails, InjectedFaultKind::disk_loses_syncs}) {
    const auto report = with(5, kind, 0);
    EXPECT_GE(report.longest_backlog, 390) << name(kind) << ": the disk accepted nothing";
    EXPECT_EQ(report.parts, 2) << name(kind) << ": the failed file is replaced";
  }
  const auto slow = with(4, InjectedFaultKind::disk_slow, 30);
  EXPECT_GE(slow.longest_backlog, 25);
  EXPECT_LE(slow.longest_backlog, 70) << "rows during a transaction wait for the next one";
}

TEST(FaultSchedules, HoldRunAfterSleepOfMachine) {
  const Schedule schedule{{.at = 600, .kind = InjectedFaultKind::machine_sleeps, .target = 0, .lasts = 300, .size = 0}};
  const auto report = carry_out(setup_for(kHour), make_setting(4, schedule));
  EXPECT_TRUE(report.violations.empty()) << report.violations.front();
  EXPECT_GT(report.seconds_in_state[static_cast<std::size_t>(RunState::held)], 0);
}

TEST(FaultSchedules, SurviveTextFormUnchanged) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed)
    for (const auto& fault : draw_schedule(seed, {})) EXPECT_EQ(parse_fault(text(fault)), fault) << text(fault);
  EXPECT_FALSE(parse_fault("12 nothing_like_it 0 1 0"));
}

/// Counts the rows of each segment.
std::map<int, std::int64_t> rows_by_segment(const SimulatedRunReport& report) {
  std::map<int, std::int64_t> rows;
  for (const auto& row : report.rows) ++rows[row.segment];
  return rows;
}

/// Crashes a run when `rows` of its seconds are on the disk and two more are not, resumes it after `down` seconds, and
/// compares it with its undisturbed twin.
void expect_twin_up_to(std::size_t rows, std::int64_t down, const SimulatedSetup& ground,
                       const SimulatedRunReport& twin) {
  auto setting = make_setting(2, {});
  setting.sync_every = static_cast<std::int64_t>(rows);
  constexpr std::int64_t kBeginsAt = 2, kNotYetOnTheDisk = 2;
  setting.schedule = {{.at = static_cast<std::int64_t>(rows) + kBeginsAt + kNotYetOnTheDisk,
                       .kind = InjectedFaultKind::program_crashes,
                       .target = 0,
                       .lasts = down,
                       .size = 0}};
  const auto report = carry_out(ground, setting);
  const auto where = ::testing::Message() << ground.profile.name << ", crash when " << rows << " rows were on the disk";
  EXPECT_TRUE(report.violations.empty()) << where << ": " << report.violations.front();
  ASSERT_EQ(report.ending, Ending::complete) << where;
  EXPECT_EQ(report.lives, 2) << where;
  EXPECT_TRUE(std::equal(twin.rows.begin(), twin.rows.begin() + static_cast<std::ptrdiff_t>(rows), report.rows.begin()))
      << where << ": differs before the crash";
  EXPECT_GT(report.rows[rows].slot, twin.rows[rows].slot) << where << ": the gap is missing";
  const auto found = rows_by_segment(report);
  for (const auto& [segment, count] : rows_by_segment(twin)) {
    const auto resumed = found.find(segment);
    ASSERT_TRUE(resumed != found.end()) << where << ": segment " << segment + 1 << " was skipped";
    EXPECT_GE(resumed->second, count) << where << ": segment " << segment + 1 << " was cut short";
  }
  EXPECT_EQ(found.size(), ground.profile.segments.size()) << where;
}

/// Returns the row counts at which a segment's last second has reached the disk.
std::vector<std::size_t> rows_at_segment_ends(const SimulatedRunReport& twin) {
  std::vector<std::size_t> ends;
  for (std::size_t i = 1; i < twin.rows.size(); ++i)
    if (twin.rows[i].segment != twin.rows[i - 1].segment) ends.push_back(i);
  return ends;
}

constexpr std::int64_t kDown = 30;

/// Crashes two runs at every `each`th segment boundary, from index `first` on. The last second on the disk is the last
/// one of a segment in one run, and the first one of the next segment in the other.
void expect_resume_equals_twin(const std::string& profile, std::size_t first, std::size_t each) {
  const auto& ground = setup_for(profile);
  const auto twin = carry_out(ground, make_setting(2, {}));
  ASSERT_EQ(twin.ending, Ending::complete);
  const auto ends = rows_at_segment_ends(twin);
  ASSERT_EQ(ends.size() + 1, ground.profile.segments.size());
  for (auto i = first; i < ends.size() && !::testing::Test::HasFailure(); i += each)
    for (const auto rows : {ends[i], ends[i] + 1}) expect_twin_up_to(rows, kDown, ground, twin);
}

TEST(Crash, AtSegmentBoundaryShortensNoLaterSegment) { expect_resume_equals_twin(kHour, 0, 1); }

#ifdef GYROTHERM_NIGHTLY
/// Tests one share of the boundaries. The shares can run in parallel.
class WholeCrash : public ::testing::TestWithParam<std::size_t> {};
constexpr std::size_t kShares = 11;

TEST_P(WholeCrash, AtEachSegmentBoundaryShortensNoLaterSegment) {
  expect_resume_equals_twin(kWhole, GetParam(), kShares);
}
INSTANTIATE_TEST_SUITE_P(Qualification, WholeCrash, ::testing::Range<std::size_t>(0, kShares));
#endif

}  // namespace
}  // namespace gyrotherm::faults
