// SPDX-License-Identifier: Apache-2.0
/// kill -9 at random moments, many times. No acknowledged second is lost. The resumed run has the same segments without
/// a shortened soak, and up to the gap it equals a run that was never killed. GYROTHERM_KILLS sets the number of kills
/// that hit a living run.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <map>
#include <optional>
#include <random>
#include <thread>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/store.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

using Nanoseconds = std::chrono::nanoseconds;

constexpr const char* kProfile = "tests/profiles/soaks.toml";
constexpr const char* kRig = "profiles/rigs/virtual.toml";

#ifdef GYROTHERM_NIGHTLY
constexpr int kKills = 1000;
#else
constexpr int kKills = 6;
#endif

int kills() {
  const char* asked = std::getenv("GYROTHERM_KILLS");
  return asked != nullptr ? std::atoi(asked) : kKills;
}

std::vector<int> list_segments(const record::Record& record) {
  std::vector<int> segments;
  for (const auto& progress : record.progress)
    if (segments.empty() || segments.back() != progress.segment) segments.push_back(progress.segment);
  return segments;
}

/// Returns, for each hold, how long the air was in its band while the hold's clock ran, according to the rows.
std::map<int, int> rows_in_band(const record::Record& record) {
  std::map<int, int> rows;
  for (std::size_t i = 0; i < record.slot.size(); ++i) {
    const auto& at = record.progress[i];
    if (at.phase == Phase::complete) continue;
    const auto& segment = record.info.segments[static_cast<std::size_t>(at.segment)];
    if (segment.hold && std::abs(record.chamber_air_c[i] - segment.target.value) <= 2) ++rows[at.segment];
  }
  return rows;
}

/// Compares bit by bit; NaN equals NaN.
bool equals(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void expect_same_up_to(std::size_t rows, const record::Record& record, const record::Record& twin) {
  for (std::size_t i = 0; i < rows; ++i) {
    ASSERT_EQ(record.slot[i], twin.slot[i]);
    ASSERT_TRUE(record.progress[i] == twin.progress[i]) << "second " << i;
    ASSERT_TRUE(equals(record.units[0].rotation[0][i], twin.units[0].rotation[0][i])) << "second " << i;
    ASSERT_TRUE(equals(record.chamber_air_c[i], twin.chamber_air_c[i])) << "second " << i;
    for (std::size_t c = 0; c < record.thermometers_c.size(); ++c)
      ASSERT_TRUE(equals(record.thermometers_c[c][i], twin.thermometers_c[c][i])) << "second " << i;
  }
}

void expect_every_slot(const record::Record& record) {
  std::int64_t expected = 0;
  auto gap = record.gaps.begin();
  for (const auto slot : record.slot) {
    while (gap != record.gaps.end() && gap->first == expected) expected = (gap++)->last + 1;
    ASSERT_EQ(slot, expected) << "every second has one sample or is in one gap";
    ++expected;
  }
  ASSERT_TRUE(gap == record.gaps.end());
}

/// Returns the sample from which a row was made.
Sample make_sample(const record::Record& record, std::size_t i) {
  const auto time = from_seconds(record.time_s[i]);
  const Instant at{time, record.info.started_utc + time};
  Sample sample{.slot = record.slot[i], .at = at, .chamber = {}, .thermometers = {}, .units = {}, .progress = {}};
  sample.chamber = {ChamberState{Celsius{record.chamber_air_c[i]}, Celsius{record.chamber_set_point_c[i]}}, at};
  for (const auto& column : record.thermometers_c) sample.thermometers.push_back({Celsius{column[i]}, at});
  sample.units = {{.count = {GyroCount{{static_cast<std::int64_t>(record.units[0].rotation[0][i])},
                                       from_seconds(record.units[0].interval_s[i])},
                             at}}};
  sample.progress = record.progress[i];
  sample.state = record.state[i];
  return sample;
}

/// Returns the last slot that a row or a gap accounts for.
std::int64_t last_accounted_slot(const record::Record& record) {
  const auto row = record.slot.empty() ? -1 : record.slot.back();
  return record.gaps.empty() ? row : std::max(row, record.gaps.back().last);
}

/// Time of the signal, measured independently of the load of the machine.
struct Moment {
  /// Last acknowledged second before the signal; −1 for the start of the program.
  std::int64_t acknowledged = -1;
  /// Processor time of the program since then.
  Nanoseconds processor{};
};

std::ostream& operator<<(std::ostream& out, const Moment& moment) {
  return out << "killed " << std::chrono::duration_cast<std::chrono::microseconds>(moment.processor).count()
             << " us of processor time after " << moment.acknowledged << " was acknowledged";
}

/// Waits for the moment. Returns false if the program ended first.
bool wait_for_moment(const Background& run, const Moment& moment) {
  constexpr Nanoseconds kLook = std::chrono::microseconds(500), kSharp = std::chrono::microseconds(50);
  while (moment.acknowledged >= 0 && last_acknowledged(run.output()) < moment.acknowledged) {
    if (!run.is_running()) return false;
    std::this_thread::sleep_for(kLook);
  }
  const auto from = moment.acknowledged >= 0 ? run.processor_time() : Nanoseconds{};
  for (auto left = moment.processor; left > Nanoseconds{}; left = from + moment.processor - run.processor_time()) {
    if (!run.is_running()) return false;
    std::this_thread::sleep_for(std::max(left, kSharp));
  }
  return true;
}

struct Tally {
  int killed{};             ///< living runs with a record
  int resumed_too{};        ///< continuations killed as well
  int before_the_record{};  ///< killed without a record
  int closed{};             ///< killed after the record was closed
  int ended{};              ///< ended before the signal
  std::int64_t lost{};
};

class Kills : public ::testing::Test {
 protected:
  /// Records the run that is never killed, and the processor time of each part of it.
  void SetUp() override {
    Background run({"run", kProfile, "--rig", kRig, "--out", folder_ / "twin.db", "--json"}, folder_ / "twin.log");
    for (auto now = run.processor_time(); run.is_running(); now = run.processor_time()) {
      whole_ = std::max(whole_, now);
      if (until_record_ == Nanoseconds{} && std::filesystem::exists(folder_ / "twin.db")) until_record_ = now;
      if (until_closing_ == Nanoseconds{} && run.output().find("recorded") != std::string::npos) until_closing_ = now;
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    ASSERT_EQ(run.wait(), 0) << run.output();
    twin_ = record::read_record(folder_ / "twin.db").value();
    soaked_ = rows_in_band(twin_);
  }

  [[nodiscard]] Nanoseconds draw_part(Nanoseconds time) { return Nanoseconds(random_() % (time.count() + 1)); }

  /// Draws a moment: one in ten during the start, one in ten during the end, four just after an acknowledgement, four
  /// anywhere.
  Moment draw(int number) {
    constexpr Nanoseconds kJustAfter = std::chrono::milliseconds(4), kBatch = std::chrono::milliseconds(40);
    const auto last = twin_.slot.back();
    switch (number % 10) {
      case 0: return {-1, draw_part(2 * until_record_)};
      case 1: return {last, draw_part(std::max(kJustAfter, whole_ - until_closing_))};
      case 2:
      case 3:
      case 4:
      case 5: return {static_cast<std::int64_t>(random_() % last), draw_part(number % 2 == 0 ? kJustAfter : kBatch)};
      default: return {-1, until_record_ + draw_part(whole_ - until_record_)};
    }
  }

  /// Runs a program that writes the record at `path` and kills it. Returns the record if it is unfinished.
  std::optional<record::Record> run_and_kill(const std::vector<std::string>& arguments, const std::string& path,
                                             const Moment& moment) {
    Background run(arguments, path + ".log");
    const bool met = wait_for_moment(run, moment);
    run.signal(SIGKILL);
    if (run.wait() != -SIGKILL || !met) return ++tally_.ended, std::nullopt;
    const auto acknowledged = last_acknowledged(run.output());
    auto record = record::read_record(path);
    if (!record && acknowledged < 0) return ++tally_.before_the_record, std::nullopt;
    EXPECT_TRUE(record) << text(record.error());
    if (!record) return std::nullopt;
    const auto last = last_accounted_slot(*record);
    tally_.lost += std::max<std::int64_t>(0, acknowledged - last);
    EXPECT_GE(last, acknowledged) << "acknowledged seconds were lost";
    const auto verified = record::verify_record(path);
    EXPECT_TRUE(verified) << text(verified.error());
    if (record->finished) return ++tally_.closed, std::nullopt;
    ++tally_.killed;
    return std::move(*record);
  }

  /// Kills one run and then resumes it. Now and then the continuation is killed as well.
  void kill_one(int number, const std::string& path) {
    const auto moment = draw(number);
    SCOPED_TRACE(::testing::Message() << "run " << number << ", " << moment);
    const auto before = run_and_kill({"run", kProfile, "--rig", kRig, "--out", path, "--json"}, path, moment);
    if (!before) return;
    const auto rows = before->slot.size();
    expect_same_up_to(rows, *before, twin_);
    constexpr int kAgainEvery = 7;
    if (number % kAgainEvery == 0 && !kill_continuation(path, rows)) return;
    resume(path, rows);
  }

  /// Kills the continuation. Returns false if it ended first.
  bool kill_continuation(const std::string& path, std::size_t rows) {
    const double left = 1 - static_cast<double>(rows) / static_cast<double>(twin_.slot.size());
    const auto rest = std::chrono::duration_cast<Nanoseconds>((whole_ - until_record_) * left);
    const Moment again{-1, until_record_ + draw_part(rest)};
    SCOPED_TRACE(::testing::Message() << "its continuation " << again);
    const bool was_killed = run_and_kill({"resume", path, "--json"}, path, again).has_value();
    tally_.resumed_too += was_killed ? 1 : 0;
    return was_killed || !record::read_record(path).value().finished;
  }

  /// Resumes a record with `rows` rows of the twin and checks the result.
  void resume(const std::string& path, std::size_t rows) {
    const auto resumed = gyrotherm_with("resume " + path);
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    const auto record = record::read_record(path).value();
    EXPECT_TRUE(record.finished);
    expect_every_slot(record);
    expect_same_up_to(rows, record, twin_);
    EXPECT_EQ(list_segments(record), list_segments(twin_));
    for (const auto& [segment, seconds] : rows_in_band(record))
      EXPECT_GE(seconds, soaked_[segment]) << "the soak of segment " << segment << " was shortened";
    ASSERT_TRUE(record::verify_record(path)) << text(record::verify_record(path).error());
  }

  const Folder folder_;
  std::mt19937_64 random_{20};
  Nanoseconds until_record_{}, until_closing_{}, whole_{};
  record::Record twin_;
  std::map<int, int> soaked_;
  Tally tally_;
};

TEST_F(Kills, LoseNoAcknowledgedSecondAndShortenNoSoak) {
  if (const char* seed = std::getenv("GYROTHERM_SEED")) random_.seed(std::strtoull(seed, nullptr, 10));
  const int most_tries = 4 * kills() + 20;
  int tries = 0;
  for (; tally_.killed < kills() && tries < most_tries && !HasFailure(); ++tries) {
    const auto path = folder_ / ("run" + std::to_string(tries) + ".db");
    kill_one(tries, path);
    for (const char* suffix : {"", "-wal", "-shm", ".status", ".sha256", ".log"})
      std::filesystem::remove(path + suffix);
    if (tries % 100 == 99) std::cout << tally_.killed << " killed of " << tries + 1 << std::endl;
  }
  std::cout << tries << " runs: " << tally_.killed << " killed alive, " << tally_.resumed_too
            << " of them while resumed; " << tally_.before_the_record << " killed before there was a record, "
            << tally_.closed << " after it was closed, " << tally_.ended << " ended first; " << tally_.lost
            << " acknowledged seconds lost\n";
  EXPECT_GE(tally_.killed, kills());
}

/// Truncates the record after the last second of each segment, and after the first second of the next.
TEST_F(Kills, AreResumedInSameSegmentsAtSegmentEnds) {
  int crashes = 0;
  for (std::size_t rows = 2; rows < twin_.slot.size() && !HasFailure(); ++rows) {
    const auto segment = [&](std::size_t row) { return twin_.progress[row].segment; };
    const bool before_the_end = segment(rows) != segment(rows - 1);
    const bool after_the_end = segment(rows - 1) != segment(rows - 2);
    if (!before_the_end && !after_the_end) continue;
    const auto path = folder_ / ("boundary" + std::to_string(rows) + ".db");
    {
      const auto store = record::Store::create(path, twin_.info).value();
      for (std::size_t i = 0; i < rows; ++i) ASSERT_TRUE(store->append(make_sample(twin_, i), {}));
      ASSERT_TRUE(store->sync());
    }
    resume(path, rows);
    EXPECT_FALSE(HasFailure()) << "crashed after second " << rows - 1;
    ++crashes;
  }
  std::cout << crashes << " crashes\n";
  EXPECT_EQ(crashes, 2 * (static_cast<int>(twin_.info.segments.size()) - 1));
}

}  // namespace
}  // namespace gyrotherm::app
