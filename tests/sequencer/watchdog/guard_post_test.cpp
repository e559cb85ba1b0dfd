// SPDX-License-Identifier: Apache-2.0
/// The posts of waiting guards, and when a guard leaves its chamber to a later run.
#include "sequencer/watchdog/guard_post.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>

#include "core/file.hpp"
#include "core/process.hpp"
#include "drivers/chamber/chamber_lock.hpp"
#include "sequencer/watchdog/safe_attempt.hpp"
#include "sequencer/watchdog/watchdog_client.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::watchdog {
namespace {

constexpr std::int64_t kDead = 1;  ///< a process that reports nothing

/// Runs `work` in another process. Returns its process id once it has ended.
pid_t run_elsewhere(const std::function<void()>& work) {
  const auto child = ::fork();
  if (child == 0) {
    work();
    ::_exit(0);
  }
  int ended = 0;
  EXPECT_EQ(::waitpid(child, &ended, 0), child);
  EXPECT_EQ(ended, 0);
  return child;
}

class GuardPostTest : public ::testing::Test {
 protected:
  ~GuardPostTest() override {
    std::error_code error;
    for (const auto* folder : {"/run/gyrotherm", "/run/lock/gyrotherm-0"})
      std::filesystem::remove(fmt::format("{}/{}.lock", folder, place), error);
  }
  const std::string place =
      fmt::format("test-{}-{}", ::testing::UnitTest::GetInstance()->current_test_info()->name(), ::getpid());
};

TEST_F(GuardPostTest, HasNoSuccessorBeforeReport) {
  GuardPost post(place, kDead);
  EXPECT_FALSE(post.find_successor());
}

TEST_F(GuardPostTest, NamesSuccessorThatHasEnded) {
  GuardPost post(place, kDead);
  const auto run = run_elsewhere([&] { relieve_guards(place, "/data/later.db"); });
  const auto words = fmt::format("process {} of {}, record /data/later.db", run, describe_user(::getuid()));
  EXPECT_EQ(post.find_successor(), words);
  EXPECT_EQ(post.find_successor(), words) << "a later question has the same answer";
}

TEST_F(GuardPostTest, IgnoresReportForOtherChamber) {
  GuardPost post(place, kDead);
  for (const auto* other : {"", "0", "-1", "#"}) relieve_guards(place + other + "x", "/data/later.db");
  EXPECT_FALSE(post.find_successor());
}

TEST_F(GuardPostTest, IgnoresReportOfWatchedProcess) {
  GuardPost post(place, ::getpid());
  relieve_guards(place, "/data/hung.db");
  EXPECT_FALSE(post.find_successor());
  run_elsewhere([&] { relieve_guards(place, "/data/later.db"); });
  EXPECT_TRUE(post.find_successor()) << "another process reports later";
}

TEST_F(GuardPostTest, IgnoresUserWhoMayNotDriveChambers) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  constexpr uid_t kStranger = 65534;
  GuardPost post(place, kDead);
  run_elsewhere([&] {
    if (::setgid(kStranger) == 0 && ::setuid(kStranger) == 0) relieve_guards(place, "/data/strange.db");
  });
  EXPECT_FALSE(post.find_successor());
}

TEST_F(GuardPostTest, IgnoresQueriesAndAnswersThem) {
  GuardPost post(place, kDead);
  for (int i = 0; i < 200; ++i) {
    if (i % 50 == 0) {
      EXPECT_FALSE(post.find_successor());
    }
    const auto guards = find_waiting_guards(place);
    ASSERT_EQ(guards.size(), 1u) << i;
  }
}

TEST_F(GuardPostTest, IsFoundWithProcessAndRecordUntilItEnds) {
  {
    const GuardPost post(place, kDead);
    const auto guards = find_waiting_guards(place);
    ASSERT_EQ(guards.size(), 1u);
    EXPECT_EQ(guards[0].pid, ::getpid());
    EXPECT_EQ(guards[0].uid, ::getuid());
    const GuardPost other(place + "x", kDead);
    EXPECT_EQ(find_waiting_guards(place).size(), 1u);
    EXPECT_GE(find_waiting_guards().size(), 2u) << "of all chambers";
  }
  EXPECT_TRUE(find_waiting_guards(place).empty());
}

TEST_F(GuardPostTest, DistinguishesLongPlaces) {
  const std::string end(100, 'y');
  GuardPost post("a" + place + end, kDead);
  relieve_guards("b" + place + end, "/data/later.db");
  EXPECT_FALSE(post.find_successor());
  run_elsewhere([&] { relieve_guards("a" + place + end, "/data/later.db"); });
  EXPECT_TRUE(post.find_successor());
}

TEST_F(GuardPostTest, RelievesEveryGuardOfChamber) {
  GuardPost first(place, kDead), second(place, kDead);
  run_elsewhere([&] { relieve_guards(place, "/data/later.db"); });
  EXPECT_TRUE(first.find_successor());
  EXPECT_TRUE(second.find_successor());
}

SafeState safe_state_for(const std::string& record) {
  SafeState state{};
  state.record = record;
  state.line = "tcp://127.0.0.1:1";
  state.link = drivers::LinkKind::tcp;
  state.map_text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/virtual.toml").value();
  return state;
}

/// Makes attempts on a chamber that does not exist.
class Attempting : public GuardPostTest {
 protected:
  [[nodiscard]] RescueResult attempt(GuardPost& post) {
    auto chamber = make_safe_state_chamber(state).value();
    chamber.place = place;
    return attempt_once(state, chamber, post, SafeTask::look);
  }
  SafeState state = safe_state_for("/data/dead.db");
};

TEST_F(Attempting, IsMadeAfterProgramOnlyHeldLock) {
  GuardPost post(place, kDead);
  run_elsewhere([&] { EXPECT_TRUE(drivers::ChamberLock::take(place, "/data/later.db")); });
  const auto rescued = attempt(post);
  EXPECT_TRUE(rescued.successor.empty());
  EXPECT_FALSE(rescued.in_use) << "a run that was refused or crashed before its guard watched leaves the chamber to it";
}

/// The whole later run lies between two attempts of the guard.
TEST_F(Attempting, IsNotMadeAfterLaterRunDroveChamberAndEnded) {
  GuardPost post(place, kDead);
  EXPECT_TRUE(attempt(post).successor.empty());
  run_elsewhere([&] {
    const auto lock = drivers::ChamberLock::take(place, "/data/later.db");
    EXPECT_TRUE(lock);
    relieve_guards(place, "/data/later.db");
  });
  const auto rescued = attempt(post);
  EXPECT_NE(rescued.successor.find("/data/later.db"), std::string::npos) << rescued.successor;
  EXPECT_TRUE(rescued.in_use);
  EXPECT_EQ(rescued.reached, SafeStage::nothing);
}

/// The watchdog of a later run. `beats` is false if its start failed before the chamber was driven.
void drive(const std::string& place, const std::string& record, bool beats) {
  auto state = safe_state_for(record);
  state.written_by = own_identity();
  auto started = WatchdogClient::start(state, place);
  ASSERT_TRUE(started) << text(started.error());
  if (beats) (*started)->heartbeat();
  (*started)->end_watch();
}

TEST_F(GuardPostTest, IsRelievedOnlyByRunThatDroveChamber) {
  const tests::TestFolder folder;
  GuardPost post(place, kDead);
  run_elsewhere([&] { drive(place, folder / "failed.db", false); });
  EXPECT_FALSE(post.find_successor()) << "a start that failed left the chamber as it was";
  run_elsewhere([&] { drive(place, folder / "later.db", true); });
  EXPECT_TRUE(post.find_successor());
}

}  // namespace
}  // namespace gyrotherm::watchdog
