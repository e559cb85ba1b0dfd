// SPDX-License-Identifier: Apache-2.0
/// The trace on a disk that refuses writes for some time, and beside the files of another run.
#include "sequencer/watchdog/trail.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "tests/support/folder.hpp"

namespace gyrotherm::watchdog {
namespace {

using std::chrono::seconds;

constexpr const char* kHung = "the program that drove it hung";

SafeState state_of_run(const std::string& record, std::int64_t pid = 4711) {
  return {.record = record,
          .line = "tcp://10.0.0.7:502",
          .link = drivers::LinkKind::tcp,
          .safe_set_point = {20},
          .written_by = {.pid = pid, .started = 1, .boot = "0b5f1c52-29c2-4d6b-8a4b-3d1c0e6c2f10"},
          .map_text = "schema = \"gyrotherm-chamber/1\"\n"};
}

/// Makes the trace unwritable: a folder has its name. Other files can be written and removed.
class Refusal {
 public:
  explicit Refusal(const std::string& record) : path_(made_safe_path(record)) {
    std::filesystem::create_directory(path_);
  }
  ~Refusal() { end(); }
  Refusal(const Refusal&) = delete;
  Refusal& operator=(const Refusal&) = delete;
  void end() {
    if (std::filesystem::is_directory(path_)) std::filesystem::remove(path_);
  }

 private:
  std::string path_;
};

RescueResult confirmed() { return {.reached = SafeStage::all, .details = "set point read back"}; }

bool has_safe_state(const SafeState& state) { return std::filesystem::exists(safe_state_path(state.record)); }

TEST(Trail, KeepsSafeStateUntilTraceIsWritten) {
  const tests::TestFolder folder;
  const auto state = state_of_run(folder / "run.db");
  ASSERT_TRUE(write_safe_state(state));
  Refusal refusal(state.record);
  TraceWriter trail(state, kHung);
  EXPECT_TRUE(trail.record(confirmed()));
  trail.remove_safe_state();
  EXPECT_FALSE(trail.settle(seconds(1)));
  EXPECT_NE(trail.write_fault().find("run.db.made-safe"), std::string::npos) << trail.write_fault();
  EXPECT_TRUE(has_safe_state(state));
  refusal.end();
  ASSERT_TRUE(trail.settle(seconds(60)));
  EXPECT_EQ(trail.write_fault(), "");
  EXPECT_FALSE(has_safe_state(state));
  const auto trace = read_trace(state.record).value().value();
  EXPECT_TRUE(trace.confirmed);
  EXPECT_EQ(trace.details, "set point read back");
}

/// A missing folder is a disk that is not mounted. The attempts continue meanwhile.
TEST(Trail, WritesNewestResultWhenFolderReturns) {
  const tests::TestFolder folder;
  const auto state = state_of_run(folder / "disk/run.db");
  TraceWriter trail(state, kHung);
  (void)trail.record({.reached = {}, .details = "no reply in 500 ms"});
  EXPECT_FALSE(trail.settle(seconds(1)));
  (void)trail.record(confirmed());
  trail.remove_safe_state();
  std::filesystem::create_directory(folder / "disk");
  ASSERT_TRUE(write_safe_state(state));
  ASSERT_TRUE(trail.settle(seconds(60)));
  EXPECT_TRUE(read_trace(state.record).value().value().confirmed);
  EXPECT_FALSE(has_safe_state(state));
}

TEST(Trail, KeepsOrderToGiveUpUntilTraceIsWritten) {
  const tests::TestFolder folder;
  const auto state = state_of_run(folder / "run.db");
  ASSERT_TRUE(write_safe_state(state));
  ASSERT_TRUE(write_give_up(state.record, "ada: wrong map"));
  Refusal refusal(state.record);
  TraceWriter trail(state, kHung);
  trail.note_given_up("ada: wrong map");
  EXPECT_FALSE(trail.settle(seconds(1)));
  EXPECT_TRUE(has_safe_state(state));
  EXPECT_EQ(read_give_up(state.record), "ada: wrong map");
  refusal.end();
  ASSERT_TRUE(trail.settle(seconds(60)));
  EXPECT_FALSE(has_safe_state(state));
  EXPECT_EQ(read_give_up(state.record), "");
  EXPECT_EQ(read_trace(state.record).value().value().given_up, "ada: wrong map");
}

/// The run is resumed while its previous guard waits for the disk.
TEST(Trail, LeavesFilesOfResumedRun) {
  const tests::TestFolder folder;
  const auto state = state_of_run(folder / "run.db");
  ASSERT_TRUE(write_safe_state(state));
  Refusal refusal(state.record);
  TraceWriter trail(state, kHung);
  (void)trail.record(confirmed());
  trail.remove_safe_state();
  EXPECT_FALSE(trail.settle(seconds(1)));
  const auto resumed = state_of_run(state.record, 4712);
  ASSERT_TRUE(write_safe_state(resumed));
  refusal.end();
  ASSERT_TRUE(trail.settle(seconds(60))) << "nothing is left to do";
  EXPECT_EQ(read_safe_state(safe_state_path(state.record)).value(), resumed);
  EXPECT_FALSE(read_trace(state.record).value());
}

TEST(Trail, StatesThatLaterRunHasTakenOver) {
  const tests::TestFolder folder;
  const auto state = state_of_run(folder / "run.db");
  ASSERT_TRUE(write_safe_state(state));
  TraceWriter trail(state, kHung);
  trail.hand_over_to("process 7 of ada (uid 1000), record /d/later.db");
  ASSERT_TRUE(trail.settle(seconds(60)));
  auto trace = read_trace(state.record).value().value();
  EXPECT_TRUE(is_taken_over(trace));
  EXPECT_FALSE(has_safe_state(state));
  trace.given_up = "ada: wrong map";
  EXPECT_FALSE(is_taken_over(trace));
}

}  // namespace
}  // namespace gyrotherm::watchdog
