// SPDX-License-Identifier: Apache-2.0
/// A hundred programs killed or stopped at random moments: the chamber is safe within 20 s. The programs mostly wait,
/// so several run at the same time. GYROTHERM_TIMES sets another number.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <random>
#include <thread>

#include "tests/apps/gyrotherm/real_rig.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::app {
namespace {

constexpr int kAtATime = 6;

struct Times {
  std::mutex mutex;
  std::vector<double> killed, stopped;  ///< s until the chamber was safe
  int failed = 0;
};

/// Kills or stops a program up to two seconds after its first second. Returns the time until the chamber was safe.
std::optional<double> seconds_until_safe(const RealLaboratory& laboratory, const std::string& record, int signal,
                                         std::mt19937_64& random) {
  Background run({"run", "tests/profiles/ten-minutes-warm.toml", "--rig", laboratory.rig(), "--out", record, "--json"},
                 record + ".log");
  if (!run.wait_for("\"acknowledged\": 0}", 120)) return {};
  std::this_thread::sleep_for(std::chrono::milliseconds(random() % 2000));
  if (!laboratory.wait_for_set_point(21.5, 60)) return {};
  run.signal(signal);
  const auto taken = laboratory.wait_for_set_point(20, 30);
  for (int i = 0; i < 100 && std::filesystem::exists(record + ".safe-state"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  return taken;
}

void end_programs(int times, unsigned seed, Times& all) {
  const tests::TestFolder folder;
  const RealLaboratory laboratory(folder / "");
  std::mt19937_64 random(seed);
  for (int i = 0; i < times; ++i) {
    const bool kill = (random() & 1) != 0;
    const auto taken =
        seconds_until_safe(laboratory, folder / fmt::format("run{}.db", i), kill ? SIGKILL : SIGSTOP, random);
    const std::lock_guard lock(all.mutex);
    if (taken) (kill ? all.killed : all.stopped).push_back(*taken);
    if (!taken || *taken > 20) ++all.failed;
  }
}

std::string figures(std::vector<double> seconds) {
  if (seconds.empty()) return "none";
  std::sort(seconds.begin(), seconds.end());
  return fmt::format("{} times, median {:.1f} s, worst {:.1f} s", seconds.size(), seconds[seconds.size() / 2],
                     seconds.back());
}

TEST(GuardedRuns, LeaveChamberSafeWithinTwentySecondsWhenKilledOrStopped) {
  if (!installed("mbpoll")) GTEST_SKIP() << "mbpoll is not installed";
  const char* wanted = std::getenv("GYROTHERM_TIMES");
  const int times = wanted ? std::atoi(wanted) : 100;
  Times all;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kAtATime; ++i)
      threads.emplace_back([&, i] { end_programs((times + i) / kAtATime, 20260101 + i, all); });
  }
  std::printf("killed: %s\nstopped: %s\n", figures(all.killed).c_str(), figures(all.stopped).c_str());
  EXPECT_EQ(all.failed, 0);
  EXPECT_GE(all.killed.size() + all.stopped.size(), static_cast<std::size_t>(times));
}

}  // namespace
}  // namespace gyrotherm::app
