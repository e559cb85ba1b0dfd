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

/// A run on a disk that hangs while the file "hangs" exists.
class HangingDisk : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(laboratory_.serves()); }

  /// Starts a run of a shipped test profile and waits for its first acknowledged second. `variable` selects the writes
  /// that hang.
  void start_run(const std::string& profile, const char* variable = "GYROTHERM_HANG") {
    const EnvironmentVariable disk("LD_PRELOAD", GYROTHERM_HANGING_DISK), file(variable, hangs_);
    const EnvironmentVariable also_with_its_sanitizer("ASAN_OPTIONS", "verify_asan_link_order=0");
    run_ = std::make_unique<Background>(std::vector<std::string>{"run", "tests/profiles/" + profile + ".toml", "--rig",
                                                                 laboratory_.rig(), "--out", record_, "--json"},
                                        folder_ / "log");
    ASSERT_TRUE(run_->wait_for(acknowledged(1), 60)) << run_->output();
  }

  void hang_disk() const { std::ofstream(hangs_) << "now"; }
  void release_disk() const { std::filesystem::remove(hangs_); }

  const Folder folder_;
  const RealLaboratory laboratory_{folder_ / ""};
  const std::string record_ = folder_ / "run.db", hangs_ = folder_ / "hangs";
  std::unique_ptr<Background> run_;
};

TEST_F(HangingDisk, DelaysNoTickIsReportedAndLosesNothing) {
  ASSERT_NO_FATAL_FAILURE(start_run("ten-minutes-warm"));

  hang_disk();
  const auto hanging = wait_for_status(record_, [](const auto& status) { return !status.storage_trouble.empty(); });
  EXPECT_NE(hanging.storage_trouble.find("a write to the disk has not returned for "), std::string::npos)
      << hanging.storage_trouble;
  const auto later = wait_for_status(record_, [&](const auto& status) { return status.slot >= hanging.slot + 2; });
  EXPECT_GE(later.slot, hanging.slot + 2) << "ticks go on";
  EXPECT_EQ(later.acknowledged, hanging.acknowledged);
  EXPECT_GE(later.backlog_s, 4);
  EXPECT_EQ(run_->output().find(acknowledged(hanging.acknowledged + 1)), std::string::npos)
      << "rows that are not on the disk are not acknowledged";
  const auto shown = gyrotherm_with("status " + record_);
  EXPECT_NE(shown.out.find("no rows can be written: a write to the disk has not returned for "), std::string::npos)
      << shown.out << shown.err;

  release_disk();
  const auto well = wait_for_status(record_, [&](const auto& status) { return status.acknowledged >= later.slot; });
  EXPECT_GE(well.acknowledged, later.slot) << "the waiting rows are on the disk";
  EXPECT_EQ(well.storage_trouble, "");
  run_->signal(SIGINT);
  EXPECT_EQ(run_->wait(), 5) << run_->output();
  expect_every_second_up_to(well.acknowledged, record_);
}

/// The guard must not take the waiting program for a dead one.
TEST_F(HangingDisk, InterruptedRunWaitsUntilItsEndIsWritten) {
  ASSERT_NO_FATAL_FAILURE(start_run("ten-minutes-warm"));
  hang_disk();
  (void)wait_for_status(record_, [](const auto& status) { return !status.storage_trouble.empty(); });
  run_->signal(SIGINT);
  EXPECT_TRUE(run_->wait_for("the program waits for the disk", 30)) << run_->output();
  std::this_thread::sleep_for(std::chrono::seconds(12));
  ASSERT_TRUE(run_->is_running()) << run_->output();
  EXPECT_FALSE(std::filesystem::exists(record_ + ".made-safe"));
  release_disk();
  EXPECT_EQ(run_->wait(), 5) << run_->output();
  const auto kept = record::read_record(record_);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_EQ(kept->events.back().event.kind, EventKind::interrupted);
}

TEST_F(HangingDisk, CompleteRunWaitsUntilItsEndIsWritten) {
  ASSERT_NO_FATAL_FAILURE(start_run("ten-seconds"));
  hang_disk();
  EXPECT_TRUE(run_->wait_for("the program waits for the disk", 60)) << run_->output();
  constexpr auto kLongerThanAnyCloseOfRecord = std::chrono::seconds(32);
  std::this_thread::sleep_for(kLongerThanAnyCloseOfRecord);
  ASSERT_TRUE(run_->is_running()) << run_->output();
  release_disk();
  EXPECT_EQ(run_->wait(), 0) << run_->output();
  EXPECT_NE(run_->output().find("recorded, "), std::string::npos) << run_->output();
  expect_every_second_up_to(9, record_);
  EXPECT_TRUE(record::read_record(record_)->finished);
}

TEST_F(HangingDisk, CompleteRunSaysWhatIsMissingIfItIsNotToWait) {
  ASSERT_NO_FATAL_FAILURE(start_run("ten-seconds"));
  hang_disk();
  EXPECT_TRUE(run_->wait_for("the program waits for the disk", 60)) << run_->output();
  run_->signal(SIGINT);
  EXPECT_TRUE(run_->wait_for("the profile is complete, but the record lacks its last seconds", 30)) << run_->output();
  EXPECT_NE(run_->output().find("the chamber stays on"), std::string::npos) << run_->output();
  release_disk();
  EXPECT_EQ(run_->wait(), 4) << run_->output();
}

TEST_F(HangingDisk, LetsRunEndWithoutStatusFile) {
  ASSERT_NO_FATAL_FAILURE(start_run("ten-seconds", "GYROTHERM_HANG_STATUS"));
  hang_disk();
  EXPECT_EQ(run_->wait(), 0) << run_->output();
  release_disk();
  const auto kept = record::read_record(record_);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_TRUE(kept->finished);
  const auto verified = record::verify_record(record_);
  ASSERT_TRUE(verified) << text(verified.error());
  EXPECT_TRUE(verified->manifest);
}

}  // namespace
}  // namespace gyrotherm::app
