// SPDX-License-Identifier: Apache-2.0
/// kill -9 during a run: acknowledged seconds are kept, and resume completes the run.
#include <gtest/gtest.h>

#include <csignal>
#include <random>
#include <thread>

#include "acquisition/record/record.hpp"
#include "acquisition/record/row.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kShortRate = "tests/profiles/short-rate.toml";
#ifdef GYROTHERM_NIGHTLY
constexpr int kKilled = 40;
#else
constexpr int kKilled = 8;
#endif

void expect_complete(const record::Record& record) {
  std::int64_t expected = 0;
  auto gap = record.gaps.begin();
  for (const auto slot : record.slot) {
    if (gap != record.gaps.end() && gap->first == expected) expected = (gap++)->last + 1;
    ASSERT_EQ(slot, expected) << "every second has one sample or is in one gap";
    ++expected;
  }
}

TEST(Crash, LosesNoAcknowledgedSecondWhenKilledAndResumes) {
  std::mt19937_64 random(20);
  for (int i = 0; i < kKilled; ++i) {
    const Folder folder;
    const auto path = folder / ("run" + std::to_string(i) + ".db");
    Background run({"run", kShortRate, "--rig", "profiles/rigs/virtual.toml", "--out", path, "--json"}, folder / "log");
    ASSERT_TRUE(run.wait_for("acknowledged", 60));
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 300));
    run.signal(SIGKILL);
    const int ended = run.wait();
    const auto acknowledged = last_acknowledged(run.output());
    {
      const auto record = record::read_record(path);
      ASSERT_TRUE(record) << text(record.error());
      ASSERT_FALSE(record->slot.empty());
      EXPECT_GE(record->slot.back(), acknowledged) << "killed for the " << i + 1 << "th time";
      expect_complete(*record);
      if (record->finished) continue;  // run ended before the signal
    }
    ASSERT_EQ(ended, -SIGKILL);
    const auto resumed = gyrotherm_with("resume " + path);
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    const auto record = record::read_record(path);
    ASSERT_TRUE(record) << text(record.error());
    EXPECT_TRUE(record->finished);
    ASSERT_EQ(record->gaps.size(), 1u);
    EXPECT_EQ(record->gaps[0].last - record->gaps[0].first + 1, 30);
    expect_complete(*record);
  }
}

TEST(Crash, StopsCleanlyOnCtrlCAndResumes) {
  const Folder folder;
  const auto path = folder / "run.db";
  Background run({"run", "profiles/random.toml", "--rig", "profiles/rigs/virtual.toml", "--out", path, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("acknowledged", 60));
  run.signal(SIGINT);
  EXPECT_EQ(run.wait(), 5) << run.output();
  const auto status = gyrotherm_with("status " + path);
  EXPECT_EQ(status.exit_code, 0);
  EXPECT_NE(status.out.find("not finished"), std::string::npos) << status.out;
  EXPECT_NE(status.out.find("  interrupted in segment "), std::string::npos) << status.out;
  EXPECT_EQ(gyrotherm_with("train " + path + " --method linear --inputs A --out " + (folder / "m.json")).exit_code, 2)
      << "an unfinished run is not reported as finished";
  EXPECT_EQ(gyrotherm_with("resume " + path + " --gap '10 min'").exit_code, 5)
      << "a long gap requires an operator's permission";
  EXPECT_EQ(gyrotherm_with("resume " + path + " --gap '10 min' --accept").exit_code, 0);
  const auto complete = gyrotherm_with("status " + path).out;
  EXPECT_NE(complete.find(" segments done\n"), std::string::npos) << complete;
  for (const auto* gone : {"  segment ", "ramping", "holding"})
    EXPECT_EQ(complete.find(gone), std::string::npos) << complete;
}

TEST(Crash, ResumeWaitsForReaderOfRecord) {
  const Folder folder;
  const auto path = folder / "run.db";
  Background run({"run", "profiles/random.toml", "--rig", "profiles/rigs/virtual.toml", "--out", path, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("acknowledged", 60));
  run.signal(SIGKILL);
  ASSERT_EQ(run.wait(), -SIGKILL);
  auto reader = record::open_record(path);
  ASSERT_TRUE(reader) << text(reader.error());
  Background resumed({"resume", path}, folder / "resumed");
  EXPECT_TRUE(resumed.wait_for("being read by another program", 60)) << resumed.output();
  reader = failure(FaultKind::storage, path, "closed");
  EXPECT_EQ(resumed.wait(), 0) << resumed.output();
}

/// A virtual run is replayed from the record, not from files that may have changed since.
TEST(Crash, ResumeNeedsOnlyRecord) {
  const Folder folder;
  const auto path = folder / "run.db";
  const auto profiles = folder / "profiles";
  ASSERT_EQ(shell("cp -r profiles " + profiles).exit_code, 0);
  Background run({"run", "profiles/random.toml", "--rig", profiles + "/rigs/virtual.toml", "--out", path, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("acknowledged", 60));
  run.signal(SIGINT);
  ASSERT_EQ(run.wait(), 5) << run.output();
  std::filesystem::remove_all(profiles);
  const auto resumed = gyrotherm_with("resume " + path);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
}

/// Starts a run and kills it after some seconds.
void kill_run(const std::string& path, const std::string& log) {
  Background run({"run", kShortRate, "--rig", "profiles/rigs/virtual.toml", "--pace", "x20", "--out", path, "--json"},
                 log);
  ASSERT_TRUE(run.wait_for("acknowledged", 60));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  run.signal(SIGKILL);
  ASSERT_EQ(run.wait(), -SIGKILL);
}

TEST(Crash, RefusesRecordThatWasMovedWithoutItsLog) {
  const Folder folder;
  const auto path = folder / "k.db", moved = folder / "v/k.db";
  kill_run(path, folder / "log");
  std::filesystem::create_directory(folder / "v");
  std::filesystem::rename(path, moved);
  const auto refused = gyrotherm_with("resume " + moved);
  EXPECT_EQ(refused.exit_code, 5) << refused.err;
  EXPECT_NE(refused.err.find("k.db-wal and k.db.status are missing"), std::string::npos) << refused.err;
  EXPECT_NE(gyrotherm_with("status " + moved).err.find("move all files of a record together"), std::string::npos);
  const auto second = gyrotherm_with(std::string("run ") + kShortRate + " --rig virtual --out " + path);
  EXPECT_EQ(second.exit_code, 4) << second.err;
  EXPECT_NE(second.err.find("k.db-wal"), std::string::npos) << second.err;
  ASSERT_TRUE(std::filesystem::exists(path + "-wal"));
  for (const char* ending : {"-wal", ".status"}) std::filesystem::rename(path + ending, moved + ending);
  const auto resumed = gyrotherm_with("resume " + moved);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  const auto record = record::read_record(moved);
  ASSERT_TRUE(record) << text(record.error());
  EXPECT_TRUE(record->finished);
  EXPECT_GT(record->gaps.at(0).first, 0) << "the acknowledged seconds remain";
}

TEST(Crash, ResumesWithoutLostFilesOnlyIfOperatorAccepts) {
  const Folder folder;
  const auto path = folder / "k.db";
  kill_run(path, folder / "log");
  std::filesystem::remove(path + "-wal");
  EXPECT_EQ(gyrotherm_with("resume " + path).exit_code, 5);
  const auto resumed = gyrotherm_with("resume --accept " + path);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_NE(resumed.err.find("without the seconds in k.db-wal"), std::string::npos) << resumed.err;
}

}  // namespace
}  // namespace gyrotherm::app
