// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/safe_relay.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

using std::chrono::seconds;
using watchdog::RelayDue;

const std::string kLongHoldAt30 = "[[segment]]\nkind = \"hold\"\nat = 30\ntime = \"9 h\"\n";

/// Relay whose attempts are counted, and fail until it is repaired.
struct CountedRelay {
  std::atomic<int> attempts = 0;
  std::atomic<bool> sticks = false;
};

class SafeRelayTest : public ::testing::Test {
 protected:
  /// Advances by one second and lets an attempt end.
  std::optional<std::string> second(RelayDue due) {
    auto words = relay.advance(due, seconds(at++));
    for (int i = 0; i < 200 && !words && has_new_attempt(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      words = relay.advance(due, seconds(at));
    }
    seen = counted->attempts;
    return words;
  }
  [[nodiscard]] bool has_new_attempt() const { return counted->attempts > seen || relay.words().empty(); }

  std::shared_ptr<CountedRelay> counted = std::make_shared<CountedRelay>();
  SafeRelay relay{drivers::RelaySettings{.after = seconds(20)},
                  [counted = counted](const drivers::RelaySettings&) -> Result<void> {
                    ++counted->attempts;
                    if (counted->sticks) return failure(FaultKind::mismatch, "relay", "it sticks");
                    return {};
                  }};
  int at = 100, seen = 0;
};

TEST_F(SafeRelayTest, OpensOnceAfterTime) {
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(relay.advance(RelayDue::in_time, seconds(at++)), std::nullopt);
    ASSERT_EQ(counted->attempts, 0) << i;
  }
  const auto words = second(RelayDue::in_time);
  ASSERT_TRUE(words);
  EXPECT_NE(words->find("was opened at "), std::string::npos) << *words;
  EXPECT_EQ(relay.words(), *words);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(relay.advance(RelayDue::in_time, seconds(at++)), std::nullopt);
  EXPECT_EQ(counted->attempts, 1);
}

TEST_F(SafeRelayTest, OpensAtOnceIfChamberCannotBecomeSafe) {
  EXPECT_TRUE(second(RelayDue::now));
  EXPECT_EQ(counted->attempts, 1);
}

TEST_F(SafeRelayTest, LeavesRelayOfSafeChamber) {
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(relay.advance(RelayDue::never, seconds(at++)), std::nullopt);
  EXPECT_EQ(counted->attempts, 0);
  EXPECT_EQ(relay.words(), "");
}

TEST_F(SafeRelayTest, IgnoresShortSilenceOfChamberThatObeys) {
  for (int i = 0; i < 200; ++i) {
    const bool is_silent = i % 20 < 6;
    EXPECT_EQ(relay.advance(is_silent ? RelayDue::in_time : RelayDue::never, seconds(at++)), std::nullopt);
  }
  EXPECT_EQ(counted->attempts, 0);
  for (int i = 0; i < 19; ++i) EXPECT_EQ(relay.advance(RelayDue::in_time, seconds(at++)), std::nullopt);
  EXPECT_EQ(counted->attempts, 0);
  at += 2;
  EXPECT_TRUE(second(RelayDue::in_time)) << "the time began with the last reading";
}

TEST_F(SafeRelayTest, RepeatsFailedAttemptEveryTenSeconds) {
  counted->sticks = true;
  const auto failed = second(RelayDue::now);
  ASSERT_TRUE(failed);
  EXPECT_NE(failed->find("NOT open: relay: it sticks"), std::string::npos) << *failed;
  for (int i = 0; i < 8; ++i) EXPECT_EQ(relay.advance(RelayDue::now, seconds(at++)), std::nullopt);
  EXPECT_EQ(counted->attempts, 1);
  counted->sticks = false;
  at += 10;
  std::optional<std::string> opened;
  for (int i = 0; i < 400 && !opened; ++i) {
    opened = relay.advance(RelayDue::now, seconds(at));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_TRUE(opened);
  EXPECT_NE(opened->find("was opened"), std::string::npos) << *opened;
  EXPECT_EQ(counted->attempts, 2);
}

TEST(SafeRelayOfRun, IsOpenedWhenAbortedChamberIsSilent) {
  tests::Bench bench(kLongHoldAt30, [](rig::RigFile& file) {
    file.simulated = false;
    // No relay listens here, so the attempt fails and is reported.
    file.safe_also = drivers::RelaySettings{.line = "tcp://127.0.0.1:1", .after = seconds(20)};
  });
  bench.seconds(10);
  bench.chamber().silent = true;
  bench.run_controller().submit(OperatorCommand::abort, "Ada");
  bench.seconds(15);
  EXPECT_EQ(bench.run_controller().end_cause().find("relay"), std::string::npos) << "within the time";
  const auto told = [&] { return bench.told(EventKind::fault, "the relay of [safe.also] is NOT open: "); };
  for (int i = 0; i < 500 && !told(); ++i) {
    bench.seconds(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(told());
  EXPECT_NE(bench.run_controller().end_cause().find("relay of [safe.also]"), std::string::npos);
}

TEST(SafeRelayOfRun, StaysClosedWhileAbortedChamberObeys) {
  tests::Bench bench(kLongHoldAt30, [](rig::RigFile& file) {
    file.simulated = false;
    file.safe_also = drivers::RelaySettings{.line = "tcp://127.0.0.1:1", .after = seconds(2)};
  });
  bench.seconds(10);
  bench.run_controller().submit(OperatorCommand::abort, "Ada");
  bench.seconds(100);
  EXPECT_EQ(bench.run_controller().end_cause().find("relay"), std::string::npos) << bench.run_controller().end_cause();
}

}  // namespace
}  // namespace gyrotherm::run
