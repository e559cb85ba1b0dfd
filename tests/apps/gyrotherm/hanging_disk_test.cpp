// SPDX-License-Identifier: Apache-2.0
/// Run on a real rig whose disk answers after seconds or never.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <thread>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/status.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

/// Environment variable for child processes, during the lifetime of the object.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::string& value) : name_(name) { ::setenv(name, value.c_str(), 1); }
  ~EnvironmentVariable() { ::unsetenv(name_); }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
};

/// Reads the status file until `wanted` accepts it. Returns the last status after 30 s.
template <class Wanted>
record::RunStatus wait_for_status(const std::string& record, Wanted accepts) {
  record::RunStatus status;
  for (int i = 0; i < 300 && !accepts(status); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const auto status_read = read_text_file(record::status_path(record)).and_then([](const auto& text) {
      return record::parse_status(text, "status");
    });
    if (status_read) status = *status_read;
  }
  return status;
}

std::string acknowledged(std::int64_t second) { return "{\"acknowledged\": " + std::to_string(second) + "}"; }

void expect_every_second_up_to(std::int64_t last, const std::string& path) {
  const auto record = record::read_record(path);
  ASSERT_TRUE(record) << text(record.error());
  std::int64_t next = 0;
  auto gap = record->gaps.begin();
  for (const auto slot : record->slot) {
    for (; gap != record->gaps.end() && gap->first == next; ++gap) next = gap->last + 1;
    ASSERT_EQ(slot, next++);
  }
  EXPECT_GE(record->slot.back(), last);
  EXPECT_TRUE(record::verify_record(path));
}

/// Starts a run of a shipped test profile, with record "run.db", on a disk that hangs while the file "hangs" exists.
/// `variable` selects the hanging writes.
std::unique_ptr<Background> start_run(const std::string& profile, const RealLaboratory& laboratory,
                                      const Folder& folder, const char* variable) {
  const EnvironmentVariable disk("LD_PRELOAD", GYROTHERM_HANGING_DISK), file(variable, folder / "hangs");
  const EnvironmentVariable also_with_its_sanitizer("ASAN_OPTIONS", "verify_asan_link_order=0");
  return std::make_unique<Background>(std::vector<std::string>{"run", "tests/profiles/" + profile + ".toml", "--rig",
                                                               laboratory.rig(), "--out", folder / "run.db", "--json"},
                                      folder / "log");
}

TEST(HangingDisk, DelaysNoTickIsReportedAndLosesNothing) {
  const Folder folder;
  const RealLaboratory laboratory(folder / "");
  ASSERT_TRUE(laboratory.serves());
  const auto record = folder / "run.db", hangs = folder / "hangs";
  const auto run = start_run("ten-minutes-warm", laboratory, folder, "GYROTHERM_HANG");
  ASSERT_TRUE(run->wait_for(acknowledged(1), 60)) << run->output();

  std::ofstream(hangs) << "now";
  const auto hanging = wait_for_status(record, [](const auto& status) { return !status.storage_trouble.empty(); });
  EXPECT_NE(hanging.storage_trouble.find("a write to the disk has not returned for "), std::string::npos)
      << hanging.storage_trouble;
  const auto later = wait_for_status(record, [&](const auto& status) { return status.slot >= hanging.slot + 2; });
  EXPECT_GE(later.slot, hanging.slot + 2) << "ticks go on";
  EXPECT_EQ(later.acknowledged, hanging.acknowledged);
  EXPECT_GE(later.backlog_s, 4);
  EXPECT_EQ(run->output().find(acknowledged(hanging.acknowledged + 1)), std::string::npos)
      << "rows that are not on the disk are not acknowledged";
  const auto shown = gyrotherm_with("status " + record);
  EXPECT_NE(shown.out.find("no rows can be written: a write to the disk has not returned for "), std::string::npos)
      << shown.out << shown.err;

  std::filesystem::remove(hangs);
  const auto well = wait_for_status(record, [&](const auto& status) { return status.acknowledged >= later.slot; });
  EXPECT_GE(well.acknowledged, later.slot) << "the waiting rows are on the disk";
  EXPECT_EQ(well.storage_trouble, "");
  run->signal(SIGINT);
  EXPECT_EQ(run->wait(), 5) << run->output();
  expect_every_second_up_to(well.acknowledged, record);
}

/// The guard must not take the waiting program for a dead one.
TEST(HangingDisk, InterruptedRunWaitsUntilItsEndIsWritten) {
  const Folder folder;
  const RealLaboratory laboratory(folder / "");
  ASSERT_TRUE(laboratory.serves());
  const auto record = folder / "run.db", hangs = folder / "hangs";
  const auto run = start_run("ten-minutes-warm", laboratory, folder, "GYROTHERM_HANG");
  ASSERT_TRUE(run->wait_for(acknowledged(1), 60)) << run->output();
  std::ofstream(hangs) << "now";
  (void)wait_for_status(record, [](const auto& status) { return !status.storage_trouble.empty(); });
  run->signal(SIGINT);
  EXPECT_TRUE(run->wait_for("the program waits for the disk", 30)) << run->output();
  std::this_thread::sleep_for(std::chrono::seconds(12));
  ASSERT_TRUE(run->is_running()) << run->output();
  EXPECT_FALSE(std::filesystem::exists(record + ".made-safe"));
  std::filesystem::remove(hangs);
  EXPECT_EQ(run->wait(), 5) << run->output();
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_EQ(kept->events.back().event.kind, EventKind::interrupted);
}

TEST(HangingDisk, CompleteRunWaitsUntilItsEndIsWritten) {
  const Folder folder;
  const RealLaboratory laboratory(folder / "");
  ASSERT_TRUE(laboratory.serves());
  const auto record = folder / "run.db", hangs = folder / "hangs";
  const auto run = start_run("ten-seconds", laboratory, folder, "GYROTHERM_HANG");
  ASSERT_TRUE(run->wait_for(acknowledged(1), 60)) << run->output();
  std::ofstream(hangs) << "now";
  EXPECT_TRUE(run->wait_for("the program waits for the disk", 60)) << run->output();
  constexpr auto kLongerThanAnyCloseOfRecord = std::chrono::seconds(32);
  std::this_thread::sleep_for(kLongerThanAnyCloseOfRecord);
  ASSERT_TRUE(run->is_running()) << run->output();
  std::filesystem::remove(hangs);
  EXPECT_EQ(run->wait(), 0) << run->output();
  EXPECT_NE(run->output().find("recorded, "), std::string::npos) << run->output();
  expect_every_second_up_to(9, record);
  EXPECT_TRUE(record::read_record(record)->finished);
}

TEST(HangingDisk, CompleteRunSaysWhatIsMissingIfItIsNotToWait) {
  const Folder folder;
  const RealLaboratory laboratory(folder / "");
  ASSERT_TRUE(laboratory.serves());
  const auto hangs = folder / "hangs";
  const auto run = start_run("ten-seconds", laboratory, folder, "GYROTHERM_HANG");
  ASSERT_TRUE(run->wait_for(acknowledged(1), 60)) << run->output();
  std::ofstream(hangs) << "now";
  EXPECT_TRUE(run->wait_for("the program waits for the disk", 60)) << run->output();
  run->signal(SIGINT);
  EXPECT_TRUE(run->wait_for("the profile is complete, but the record lacks its last seconds", 30)) << run->output();
  EXPECT_NE(run->output().find("the chamber stays on"), std::string::npos) << run->output();
  std::filesystem::remove(hangs);
  EXPECT_EQ(run->wait(), 4) << run->output();
}

TEST(HangingDisk, LetsRunEndWithoutStatusFile) {
  const Folder folder;
  const RealLaboratory laboratory(folder / "");
  ASSERT_TRUE(laboratory.serves());
  const auto record = folder / "run.db", hangs = folder / "hangs";
  const auto run = start_run("ten-seconds", laboratory, folder, "GYROTHERM_HANG_STATUS");
  ASSERT_TRUE(run->wait_for(acknowledged(1), 60)) << run->output();
  std::ofstream(hangs) << "now";
  EXPECT_EQ(run->wait(), 0) << run->output();
  std::filesystem::remove(hangs);
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_TRUE(kept->finished);
  const auto verified = record::verify_record(record);
  ASSERT_TRUE(verified) << text(verified.error());
  EXPECT_TRUE(verified->manifest);
}

}  // namespace
}  // namespace gyrotherm::app
