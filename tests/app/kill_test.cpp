/// kill -9 at any moment, many times: nothing that was printed as acknowledged is lost, the run that resume ends has
/// the same segments with no soak shortened, and up to the gap it is the run that was never killed.
/// GYROTHERM_KILLS in the environment: how many.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <map>
#include <random>
#include <thread>

#include "acquisition/chain_check.hpp"
#include "acquisition/record.hpp"
#include "acquisition/store.hpp"
#include "tests/app/program.hpp"

namespace gyrotherm {
namespace {

using std::chrono::steady_clock;

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

/// The last second that the program said it had acknowledged; −1 if none.
std::int64_t last_acknowledged(const std::string& output) {
  const std::string key = "{\"acknowledged\": ";
  auto at = output.rfind(key);
  while (at != std::string::npos && output.find('}', at) == std::string::npos)
    at = at == 0 ? std::string::npos : output.rfind(key, at - 1);
  return at == std::string::npos ? -1 : std::stoll(output.substr(at + key.size()));
}

std::vector<int> segments_of(const Record& record) {
  std::vector<int> segments;
  for (const auto& progress : record.progress)
    if (segments.empty() || segments.back() != progress.segment) segments.push_back(progress.segment);
  return segments;
}

/// Of each hold: how long the air was in its band while its clock ran, as the record's rows have it.
std::map<int, int> rows_in_band(const Record& record) {
  std::map<int, int> rows;
  for (std::size_t i = 0; i < record.slot.size(); ++i) {
    const auto& at = record.progress[i];
    if (at.phase == Phase::complete) continue;
    const auto& segment = record.info.segments[static_cast<std::size_t>(at.segment)];
    if (segment.hold && std::abs(record.chamber_air_c[i] - segment.target.value) <= 2) ++rows[at.segment];
  }
  return rows;
}

/// Bit for bit, NaN being equal to NaN.
bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void expect_same_up_to(std::size_t rows, const Record& record, const Record& twin) {
  for (std::size_t i = 0; i < rows; ++i) {
    ASSERT_EQ(record.slot[i], twin.slot[i]);
    ASSERT_TRUE(record.progress[i] == twin.progress[i]) << "second " << i;
    ASSERT_TRUE(same(record.gyro[i], twin.gyro[i])) << "second " << i;
    ASSERT_TRUE(same(record.chamber_air_c[i], twin.chamber_air_c[i])) << "second " << i;
    for (std::size_t c = 0; c < record.thermometers_c.size(); ++c)
      ASSERT_TRUE(same(record.thermometers_c[c][i], twin.thermometers_c[c][i])) << "second " << i;
  }
}

void expect_every_slot(const Record& record) {
  std::int64_t expected = 0;
  auto gap = record.gaps.begin();
  for (const auto slot : record.slot) {
    while (gap != record.gaps.end() && gap->first == expected) expected = (gap++)->last + 1;
    ASSERT_EQ(slot, expected) << "every second has one sample or lies in one gap";
    ++expected;
  }
  ASSERT_TRUE(gap == record.gaps.end());
}

/// A row of a record as it was before it was written.
Sample sample_of(const Record& record, std::size_t i) {
  const auto time = from_seconds(record.time_s[i]);
  const Instant at{time, record.info.started_utc + time};
  Sample sample{.slot = record.slot[i], .at = at, .chamber = {}, .thermometers = {}, .gyro = {}, .progress = {}};
  sample.chamber = {ChamberState{Celsius{record.chamber_air_c[i]}, Celsius{record.chamber_set_point_c[i]}}, at};
  for (const auto& column : record.thermometers_c) sample.thermometers.push_back({Celsius{column[i]}, at});
  sample.gyro = {PulseCount{static_cast<std::int64_t>(record.gyro[i]), from_seconds(record.gyro_interval_s[i])}, at};
  sample.progress = record.progress[i];
  sample.state = record.state[i];
  return sample;
}

struct Tally {
  int killed{};
  int before_the_record{};  ///< there was no record yet
  int finished{};           ///< the run was quicker than the signal
  std::int64_t lost{};
};

class Kills : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto began = steady_clock::now();
    const auto ran =
        gyrotherm_with(std::string("run ") + kProfile + " --rig " + kRig + " --out " + folder_ / "twin.db");
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    whole_ = std::chrono::duration_cast<std::chrono::milliseconds>(steady_clock::now() - began);
    twin_ = read_record(folder_ / "twin.db").value();
    soaked_ = rows_in_band(twin_);
  }

  /// One run, killed after `moment`, and its continuation.
  void kill_after(std::chrono::milliseconds moment, const std::string& path, Tally& tally) {
    Background run({"run", kProfile, "--rig", kRig, "--out", path, "--json"}, path + ".log");
    std::this_thread::sleep_for(moment);
    run.signal(SIGKILL);
    if (run.wait() != -SIGKILL) return void(++tally.finished);
    const auto acknowledged = last_acknowledged(run.output());
    const auto before = read_record(path);
    if (!before && acknowledged < 0) return void(++tally.before_the_record);
    ASSERT_TRUE(before) << text(before.error());
    ++tally.killed;
    const auto rows = before->slot.size();
    const auto last = rows == 0 ? -1 : before->slot.back();
    tally.lost += std::max<std::int64_t>(0, acknowledged - last);
    ASSERT_GE(last, acknowledged) << "seconds were lost that had been acknowledged";
    ASSERT_TRUE(verify_record(path)) << text(verify_record(path).error());
    expect_same_up_to(rows, *before, twin_);
    if (before->finished) return void(++tally.finished);  // killed on its way out
    resume(path, rows);
  }

  /// What the program makes of a record that has only so many rows of the twin.
  void resume(const std::string& path, std::size_t rows) {
    const auto resumed = gyrotherm_with("resume " + path);
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    const auto record = read_record(path).value();
    EXPECT_TRUE(record.finished);
    expect_every_slot(record);
    expect_same_up_to(rows, record, twin_);
    EXPECT_EQ(segments_of(record), segments_of(twin_));
    for (const auto& [segment, seconds] : rows_in_band(record))
      EXPECT_GE(seconds, soaked_[segment]) << "the soak of segment " << segment << " was shortened";
    ASSERT_TRUE(verify_record(path)) << text(verify_record(path).error());
  }

  const Folder folder_;
  std::chrono::milliseconds whole_{};
  Record twin_;
  std::map<int, int> soaked_;
};

TEST_F(Kills, AtAnyMomentLoseNothingAcknowledgedAndShortenNoSoak) {
  const char* seed = std::getenv("GYROTHERM_SEED");
  std::mt19937_64 random(seed != nullptr ? std::strtoull(seed, nullptr, 10) : 20);
  Tally tally;
  for (int i = 0; i < kills() && !HasFailure(); ++i) {
    const auto path = folder_ / ("run" + std::to_string(i) + ".db");
    const auto moment = std::chrono::milliseconds(random() % static_cast<std::uint64_t>(whole_.count() + 1));
    kill_after(moment, path, tally);
    EXPECT_FALSE(HasFailure()) << "run " << i << ", killed after " << moment.count() << " ms";
    for (const char* suffix : {"", "-wal", "-shm", ".status", ".sha256", ".log"})
      std::filesystem::remove(path + suffix);
  }
  std::cout << tally.killed << " killed and resumed, " << tally.before_the_record
            << " killed before there was a record, " << tally.finished << " ended first; " << tally.lost
            << " acknowledged seconds lost\n";
  EXPECT_GT(tally.killed, 0);
}

/// The last second of each segment, and the first of the next, were the last that came to the disk.
TEST_F(Kills, AtEachEndOfASegmentGoOnInTheSameSegments) {
  int crashes = 0;
  for (std::size_t rows = 2; rows < twin_.slot.size() && !HasFailure(); ++rows) {
    const auto segment = [&](std::size_t row) { return twin_.progress[row].segment; };
    const bool before_the_end = segment(rows) != segment(rows - 1);
    const bool after_the_end = segment(rows - 1) != segment(rows - 2);
    if (!before_the_end && !after_the_end) continue;
    const auto path = folder_ / ("boundary" + std::to_string(rows) + ".db");
    {
      const auto store = Store::create(path, twin_.info).value();
      for (std::size_t i = 0; i < rows; ++i) ASSERT_TRUE(store->append(sample_of(twin_, i), {}));
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
}  // namespace gyrotherm
