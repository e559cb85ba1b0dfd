// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/resume.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/sequencer/profile/profiles.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

constexpr Celsius kMild{20};

/// Returns a soak at 60 °C, interrupted for 30 s.
InterruptedRun interrupted_hot_soak() {
  return {.lowest = {60}, .highest = {60}, .air = Celsius{59.8}, .down = std::chrono::seconds(30)};
}
InterruptedRun interrupted_cold_soak() {
  return {.lowest = {-40}, .highest = {-40}, .air = Celsius{-39.9}, .down = std::chrono::seconds(30)};
}

/// Returns why a finished record with these states and events of the kind state cannot be resumed.
std::string refusal_after(std::vector<RunState> states, const std::vector<std::string>& texts) {
  record::Record record;
  record.finished = true;
  record.state = std::move(states);
  std::int64_t number = 0;
  for (const auto& text : texts) {
    record::RecordedEvent recorded;
    recorded.event = {.at = {}, .kind = EventKind::state, .text = text, .number = ++number};
    recorded.event.at.utc = kVirtualEpoch + std::chrono::minutes(number);
    record.events.push_back(std::move(recorded));
  }
  const auto planned = plan_continuation(record, "run.db", Downtime(Duration{}), 1);
  return planned ? "it is resumed" : text(planned.error());
}

TEST(FinishedRun, NamesUserAndTimeOfStop) {
  const auto why = refusal_after({RunState::execute, RunState::aborting, RunState::stopped},
                                 {"held: paused by eve (uid 1)", "execute",
                                  "aborting: stopped by ada (uid 1000): smoke", "stopped by ada (uid 1000): smoke"});
  EXPECT_NE(why.find("this run was stopped by ada (uid 1000): smoke, at " +
                     civil_time(kVirtualEpoch + std::chrono::minutes(4))),
            std::string::npos)
      << why;
  EXPECT_NE(why.find("a stop is final"), std::string::npos) << why;
  EXPECT_EQ(why.find("eve"), std::string::npos) << why;
}

TEST(FinishedRun, IsNotCalledStoppedWhenItCompleted) {
  const std::string finished = "run.db: this run has finished; there is nothing to resume";
  EXPECT_EQ(refusal_after({RunState::execute, RunState::complete}, {"complete"}), finished);
  EXPECT_EQ(refusal_after({RunState::complete}, {"stopped by ada", "execute", "complete"}), finished)
      << "a stop of an earlier time";
  EXPECT_EQ(refusal_after({RunState::stopped}, {}), finished) << "a record without events";
  EXPECT_EQ(refusal_after({}, {"stopped by ada"}), finished) << "a record without states";
}

Reentry way(const InterruptedRun& stood, double air_now) { return judge_reentry(stood, kMild, {air_now}).way; }

TEST(ResumeRule, ContinuesAfterShortGapWithUnchangedAir) {
  EXPECT_EQ(way(interrupted_hot_soak(), 59.8), Reentry::go_on);
  EXPECT_EQ(way(interrupted_hot_soak(), 57.8), Reentry::go_on);
  EXPECT_EQ(way(interrupted_cold_soak(), -38), Reentry::go_on);
  EXPECT_EQ(judge_reentry(interrupted_hot_soak(), kMild, {59}).why, "");
}

TEST(ResumeRule, StabilisesAfterDriftToMildSide) {
  EXPECT_EQ(way(interrupted_hot_soak(), 57.7), Reentry::stabilise);
  EXPECT_EQ(way(interrupted_hot_soak(), 21), Reentry::stabilise);
  EXPECT_EQ(way(interrupted_cold_soak(), -37), Reentry::stabilise);
  EXPECT_EQ(way(interrupted_cold_soak(), 21.9), Reentry::stabilise);
  EXPECT_EQ(judge_reentry(interrupted_hot_soak(), kMild, {50}).why,
            "the air is at 50.00 °C; it was at 59.80 °C before the interruption");
}

TEST(ResumeRule, AsksOperatorAfterDriftPastSegmentOnHarmfulSide) {
  EXPECT_EQ(way(interrupted_hot_soak(), 62.1), Reentry::ask);
  EXPECT_EQ(way(interrupted_hot_soak(), 17.9), Reentry::ask) << "past the mild temperature, on the other side";
  EXPECT_EQ(way(interrupted_cold_soak(), -42.1), Reentry::ask);
  EXPECT_EQ(way(interrupted_cold_soak(), 22.1), Reentry::ask);
}

TEST(ResumeRule, AsksOperatorWhenInstrumentDiffersFromStart) {
  const std::map<std::string, std::string> at_start{
      {"chamber", "F4T 111"}, {"thermometer 1", "LSCI,1"}, {"gyro", "G1"}};
  EXPECT_EQ(compare_identities(at_start, at_start), "");
  EXPECT_EQ(compare_identities({}, at_start), "") << "a record of 0.1.0 has no identities";
  for (const auto* title : {"chamber", "thermometer 1", "gyro"}) {
    auto now = at_start;
    now[title] = "other 222";
    auto stood = interrupted_hot_soak();
    stood.mismatched_instruments = compare_identities(at_start, now);
    EXPECT_NE(stood.mismatched_instruments.find("other 222"), std::string::npos) << title;
    EXPECT_NE(stood.mismatched_instruments.find(at_start.at(title)), std::string::npos) << "names both";
    EXPECT_EQ(way(stood, 59.8), Reentry::ask);
    EXPECT_EQ(judge_reentry(stood, kMild, {59.8}).why, stood.mismatched_instruments);
  }
}

TEST(ResumeRule, AsksIfSomebodyMayBeAtChamber) {
  auto stood = interrupted_hot_soak();
  stood.given_up = "ada (1000): unplugged, I reach inside";
  EXPECT_EQ(judge_reentry(stood, kMild, {59}).why,
            "the guard was ordered to give up by ada (1000): unplugged, I reach inside");
  stood = interrupted_hot_soak();
  stood.found_off = true;
  EXPECT_EQ(way(stood, 59), Reentry::ask);
}

TEST(ResumeRule, AsksOperatorAfterLongGapAtAnyAir) {
  auto stood = interrupted_hot_soak();
  stood.down = std::chrono::seconds(120);
  EXPECT_EQ(way(stood, 59.8), Reentry::go_on);
  stood.down = std::chrono::seconds(121);
  EXPECT_EQ(way(stood, 59.8), Reentry::ask);
  EXPECT_EQ(judge_reentry(stood, kMild, {59.8}).why, "down for 2 min 01 s, longer than 2 min 00 s");
}

TEST(ResumeRule, AsksOperatorWhenDowntimeIsUnknown) {
  using std::chrono_literals::operator""s;
  using std::chrono_literals::operator""h;
  for (const Duration known : {Duration(0s), Duration(-2s), Duration(90s), Duration(24h * 366)})
    EXPECT_EQ(unknown_downtime_reason(known), "") << format_duration(known);
  EXPECT_EQ(unknown_downtime_reason(-10h),
            "the clock is 10 h 00 min 00 s behind the last second of the record: the downtime is unknown");
  EXPECT_EQ(unknown_downtime_reason(24h * 20'000),
            "by the clock it was down for 20000 days, which is implausible: the downtime is unknown");
  auto stood = interrupted_hot_soak();
  EXPECT_EQ(describe_downtime(stood), "30 s");
  stood.why_unknown = unknown_downtime_reason(-10h);
  EXPECT_EQ(way(stood, 59.8), Reentry::ask);
  EXPECT_EQ(describe_downtime(stood), "an unknown time");
}

TEST(ResumeRule, AsksOperatorWhenOnlyWallClockShowsDowntime) {
  auto stood = interrupted_hot_soak();
  stood.why_asks = "the machine was restarted meanwhile";
  EXPECT_EQ(way(stood, 59.8), Reentry::ask);
  EXPECT_EQ(judge_reentry(stood, kMild, {59.8}).why, stood.why_asks);
}

constexpr Duration kLastSecond = std::chrono::days(20'000);  ///< UTC of the record's last second

/// Returns a real run. Its last second, 100, was stored 5000 s after the machine's start.
record::Record record_stopped_at_100() {
  record::Record record;
  record.info.id = "run";
  record.slot = {98, 99, 100};
  record.last_utc = kLastSecond;
  return record;
}

record::RunStatus status_at(std::int64_t slot) {
  record::RunStatus status;
  status.id = "run";
  status.slot = slot;
  status.written_utc = kLastSecond;
  status.written_since_boot = kSecond * (5000 + slot - 100);
  status.written_in_boot = "this boot";
  status.slot_since_boot = status.written_since_boot;
  status.slot_in_boot = status.written_in_boot;
  return status;
}

TEST(Downtime, FollowsBootClockRegardlessOfWallClock) {
  const auto record = record_stopped_at_100();
  for (const Duration down : {kSecond * 3, kSecond * 119, kSecond * 200, kSecond * 40'000})
    for (const Duration step : {kSecond * 0, kSecond * -190, kSecond * 3600, kSecond * -1'000'000'000}) {
      const auto found = compute_downtime(
          record, status_at(100),
          {.utc = kLastSecond + down + step, .since_boot = kSecond * 5000 + down, .boot = "this boot"});
      EXPECT_EQ(found.down, down) << to_seconds(step);
      EXPECT_EQ(found.why_asks, "");
    }
}

TEST(Downtime, CountsFromLastSecondOfRecordWhenStatusIsOfAnotherRun) {
  const auto record = record_stopped_at_100();
  const MachineTime now{.utc = {}, .since_boot = kSecond * 5060, .boot = "this boot"};
  for (const std::int64_t slot : {-1, 90, 100, 103})
    EXPECT_EQ(compute_downtime(record, status_at(slot), now).down, kSecond * 60);
}

/// A program that waits for the disk, or that only reopened the record, writes the file without a new second.
TEST(Downtime, CountsFromLastSecondAlthoughFileWasRewritten) {
  auto status = status_at(100);
  status.written_since_boot += kSecond * 3600;
  const MachineTime now{.utc = {}, .since_boot = kSecond * (5000 + 3610), .boot = "this boot"};
  EXPECT_EQ(compute_downtime(record_stopped_at_100(), status, now).down, kSecond * 3610);
  status.written_in_boot = "this boot";
  status.slot_in_boot = "previous boot";
  EXPECT_NE(compute_downtime(record_stopped_at_100(), status, now).why_asks, "");
}

TEST(Downtime, RequiresOperatorWhenBootClockIsUnusable) {
  const auto record = record_stopped_at_100();
  const MachineTime now{.utc = kLastSecond + kSecond * 60, .since_boot = kSecond * 20, .boot = "next boot"};
  auto of_another_run = status_at(100), without_boot = status_at(100);
  of_another_run.id = "another";
  without_boot.slot_in_boot.clear();
  for (const auto& status : {std::optional<record::RunStatus>(), std::optional(status_at(100)),
                             std::optional(of_another_run), std::optional(without_boot)}) {
    const auto found = compute_downtime(record, status, now);
    EXPECT_EQ(found.down, kSecond * 60);
    EXPECT_NE(found.why_asks, "");
  }
  auto set_back = now;
  set_back.utc -= kSecond * 50;  // leaves 10 s of downtime
  const auto impossible = compute_downtime(record, status_at(100), set_back);
  EXPECT_NE(impossible.why_asks.find("the machine was started 20 s ago"), std::string::npos) << impossible.why_asks;
  auto no_boot = now;
  no_boot.boot.clear();
  EXPECT_NE(compute_downtime(record, without_boot, no_boot).why_asks, "") << "both boot ids are missing";
}

TEST(ResumeRule, AsksOperatorAfterInterlockAbortOrOperatorHold) {
  auto stood = interrupted_hot_soak();
  stood.aborted = true;
  EXPECT_EQ(way(stood, 59.8), Reentry::ask);
  EXPECT_EQ(judge_reentry(stood, kMild, {59.8}).why, "the run was aborted") << "by whomever";
  stood = interrupted_hot_soak();
  stood.held = true;
  EXPECT_EQ(way(stood, 59.8), Reentry::ask);
}

TEST(ResumeRule, AsksOperatorIfRecordLacksEnd) {
  auto stood = interrupted_hot_soak();
  stood.end_recorded = false;
  EXPECT_EQ(way(stood, 59.8), Reentry::go_on) << "the program was killed";
  stood.end_lost = true;
  EXPECT_EQ(way(stood, 59.8), Reentry::ask);
}

TEST(ResumeRule, StabilisesWhenAirWasNeverRead) {
  auto stood = interrupted_hot_soak();
  stood.air.reset();
  EXPECT_EQ(way(stood, 59.8), Reentry::stabilise);
  EXPECT_EQ(way(stood, 70), Reentry::ask);
}

TEST(ResumeRule, UsesExtremesOfRamp) {
  const auto profile = profile::parsed(profile::kHold20 + "[[segment]]\nkind = \"ramp\"\nto = -30\nrate = 5\n");
  const auto hold = segment_extremes(profile, profile::Holding{0, {}, {}});
  EXPECT_EQ(hold.lowest, Celsius{20});
  EXPECT_EQ(hold.highest, Celsius{20});
  const auto ramp = segment_extremes(profile, profile::Ramping{1, std::chrono::seconds(10)});
  EXPECT_EQ(ramp.lowest, Celsius{-30});
  EXPECT_EQ(ramp.highest, Celsius{20});
}

/// The air reaches 50 °C long before the block does.
TEST(Resume, CreditsNoSoakByAirWhenThermometerDecides) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/soak-on-block.toml");
  ASSERT_EQ(dry_run.run(1200), RunOutcome::going_on);
  const auto whole = record::read_record(dry_run.path());
  ASSERT_TRUE(whole) << text(whole.error());
  const auto& block = whole->thermometers_c[1];
  std::size_t last = 60;
  while (std::abs(whole->chamber_air_c[last] - 50) > 0.2) ++last;
  ASSERT_GT(std::abs(block[last] - 50), 3);
  std::filesystem::remove(dry_run.path());
  ASSERT_EQ(dry_run.run(static_cast<std::int64_t>(last) + 1), RunOutcome::going_on);
  const auto on = plan_continuation(record::read_record(dry_run.path()).value(), dry_run.path(), kSecond, 0);
  ASSERT_TRUE(on) << text(on.error());
  EXPECT_EQ(profile_position(on->profile, on->state).soaked, Duration{});
  EXPECT_EQ(profile_position(on->profile, on->state), whole->progress[last + 1]);
}

/// The run has never been at the profile's set point, so that there is no earlier air to compare with.
TEST(Resume, HasNoAirWhenRunHadNotReachedProfile) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/soak-on-block.toml");
  ASSERT_EQ(dry_run.run(100), RunOutcome::going_on);
  auto record = record::read_record(dry_run.path()).value();
  const auto air_after = [&](std::size_t seconds_in_execute) {
    record.state.assign(record.state.size(), RunState::suspended);
    std::fill_n(record.state.begin(), seconds_in_execute, RunState::execute);
    return plan_continuation(record, dry_run.path(), kSecond, 0)->interruption.air;
  };
  EXPECT_FALSE(air_after(0));
  EXPECT_EQ(air_after(70), Celsius{record.chamber_air_c[69]}) << "the last second with a running clock";
  EXPECT_FALSE(is_in_place({19.8}, {-30}, air_after(0)));
}

constexpr profile::ChamberLimits kSlow{{-40}, {90}, CelsiusPerMinute{1}, CelsiusPerMinute{6}};

/// Entry to `goal` of a chamber with this air and set point.
EntryPoint enter(double goal, double air, double shown, EntryClock clock,
                 ChamberActivity activity = ChamberActivity::running) {
  const auto entry = entry_at({goal}, {air}, is_in_place({air}, {goal}, {}), kSlow);
  return avoid_step(entry, {.air = {air}, .set_point = {shown}, .activity = activity}, kSlow, clock);
}

TEST(Entry, RampsWithinResumeBandFromAir) {
  const auto start = enter(24.9, 23, 23, EntryClock::waits);
  EXPECT_EQ(start.set_point, Celsius{23});
  EXPECT_TRUE(start.away) << "the time of the hold begins after the ramp";
  const auto resumed = enter(31.3, 29.3, 23, EntryClock::runs);
  EXPECT_EQ(resumed.set_point, Celsius{29.3});
  EXPECT_TRUE(resumed.behind && !resumed.away) << "no time is lost";
}

TEST(Entry, SendsSetPointThatIsNoStep) {
  struct Case {
    const char* what;
    double goal, air, shown;
    bool steps;
  };
  for (const auto& one :
       {Case{"the chamber was left at the set point", 31.3, 29.3, 31.3, false},
        Case{"rounded by the controller", 31.3333, 29.4, 31.3, false}, Case{"the air is there", 23, 22.95, 80, false},
        Case{"farther than the resolution", 23, 22.85, 80, true},
        Case{"within a second of cooling", 23, 23.099, 80, false},
        Case{"the shown set point is unknown", 23, 22, std::nan(""), true}})
    for (const auto clock : {EntryClock::waits, EntryClock::runs}) {
      const auto entry = enter(one.goal, one.air, one.shown, clock);
      EXPECT_EQ(entry.away || entry.behind, one.steps) << one.what;
      EXPECT_EQ(entry.set_point, Celsius{one.steps ? one.air : one.goal}) << one.what;
    }
}

TEST(Entry, IgnoresSetPointOfChamberThatIsOff) {
  for (const auto activity : {ChamberActivity::off, ChamberActivity::not_following, ChamberActivity::done})
    EXPECT_TRUE(enter(24.9, 23, 24.9, EntryClock::waits, activity).away) << name(activity);
  EXPECT_FALSE(enter(24.9, 23, 24.9, EntryClock::waits, ChamberActivity::unknown).away) << "its map shows no state";
}

/// The air is where it was when the run stopped, but far behind the profile.
TEST(Entry, WaitsIfAirIsFartherThanResumeBand) {
  const EntryPoint direct{.set_point = {40}};
  const auto entry = avoid_step(direct, {.air = {35}, .set_point = {23}}, kSlow, EntryClock::runs);
  EXPECT_TRUE(entry.away && !entry.behind);
  EXPECT_EQ(entry.set_point, Celsius{35});
}

TEST(Entry, StartsInsideLimits) {
  EXPECT_EQ(enter(-40, -41.5, 23, EntryClock::runs).set_point, Celsius{-40});
  EXPECT_EQ(enter(90, 91.5, 23, EntryClock::waits).set_point, Celsius{90});
}

TEST(Resume, RequiresOperatorAfterForeignSetPoint) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/soak-on-block.toml");
  ASSERT_EQ(dry_run.run(50), RunOutcome::going_on);
  auto record = record::read_record(dry_run.path()).value();
  const auto way_after = [&](EventKind kind, const std::string& interlock) {
    record.events.push_back(
        {.slot = 49, .event = {.at = {}, .kind = kind, .text = {}, .about = {interlock, "suspend"}}});
    return judge_reentry(plan_continuation(record, dry_run.path(), kSecond, 0)->interruption, kMild, {20}).way;
  };
  EXPECT_EQ(way_after(EventKind::interlock, "door"), Reentry::go_on);
  EXPECT_EQ(way_after(EventKind::interlock, "foreign_set_point"), Reentry::ask);
  EXPECT_EQ(way_after(EventKind::acknowledged, "foreign_set_point"), Reentry::ask);
  EXPECT_EQ(way_after(EventKind::recovered, "door"), Reentry::ask);
  EXPECT_EQ(way_after(EventKind::recovered, "foreign_set_point"), Reentry::go_on);
  EXPECT_EQ(way_after(EventKind::fault, "foreign_set_point"), Reentry::ask) << "also if its reaction is warn";
  EXPECT_EQ(way_after(EventKind::resumed, ""), Reentry::go_on) << "an operator has resumed since";
}

/// The deadline that has passed would abort the run in its first second, regardless of the operator.
TEST(Resume, RestartsDeadlineThatEndedRun) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/soak-on-block.toml");
  ASSERT_EQ(dry_run.run(600), RunOutcome::going_on);
  auto record = record::read_record(dry_run.path()).value();
  auto& last = record.progress.back();
  ASSERT_EQ(last.segment, 2);
  last.phase = Phase::overdue;
  last.in_segment = std::chrono::hours(11);
  last.soaked = std::chrono::minutes(2);
  record.state.back() = RunState::aborted;
  const auto on = plan_continuation(record, dry_run.path(), kSecond, 0);
  ASSERT_TRUE(on) << text(on.error());
  EXPECT_TRUE(on->interruption.aborted);
  const auto stands = profile_position(on->profile, on->state);
  EXPECT_EQ(stands.phase, Phase::holding);
  EXPECT_EQ(stands.soaked, last.soaked);
  EXPECT_LT(stands.in_segment, std::chrono::hours(1));
}

}  // namespace
}  // namespace gyrotherm::run
