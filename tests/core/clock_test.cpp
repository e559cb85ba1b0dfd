// SPDX-License-Identifier: Apache-2.0
#include "core/clock.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

namespace gyrotherm {
namespace {

using std::chrono::hours;
using std::chrono::seconds;

TEST(VirtualClock, AdvancesOnlyOnRequest) {
  VirtualClock clock;
  EXPECT_EQ(clock.now().since_start, Duration::zero());
  EXPECT_EQ(clock.now().utc, kVirtualEpoch);
  clock.advance(seconds(5));
  EXPECT_EQ(clock.now().since_start, seconds(5));
  EXPECT_EQ(clock.now().utc, kVirtualEpoch + seconds(5));
}

TEST(VirtualClock, StartsAtGivenOffset) {
  const VirtualClock clock(hours(3), hours(24));
  EXPECT_EQ(clock.now().since_start, hours(3));
  EXPECT_EQ(clock.now().utc, kVirtualEpoch + hours(27));
}

TEST(VirtualClock, ContinuesFromElapsedTimeOfRun) { EXPECT_EQ(VirtualClock(hours(3)).now().since_start, hours(3)); }

TEST(SteadyClock, NeverDecreasesAndIncludesEarlierTime) {
  const SteadyClock clock(hours(1));
  const auto first = clock.now();
  const auto second = clock.now();
  EXPECT_GE(first.since_start, hours(1));
  EXPECT_LT(first.since_start, hours(2));
  EXPECT_GE(second.since_start, first.since_start);
  EXPECT_GT(first.utc, kVirtualEpoch - hours(24 * 365));
}

/// Enters a time namespace whose boot-time clock is ahead by `slept`, as after a suspension. Returns false if this user
/// may not create one.
bool enter_suspended_time_namespace(seconds slept) {
  if (::unshare(CLONE_NEWTIME) != 0) return false;
  std::ofstream("/proc/self/timens_offsets") << "boottime " << slept.count() << " 0";
  const int entrance = ::open("/proc/self/ns/time_for_children", O_RDONLY | O_CLOEXEC);
  return entrance >= 0 && ::setns(entrance, CLONE_NEWTIME) == 0;
}

TEST(SteadyClock, IncludesTimeInSuspension) {
  constexpr int kNotPermitted = 77;  // exit code
  const auto child = ::fork();
  if (child == 0) {
    const SteadyClock clock;
    const auto before = clock.now();
    if (!enter_suspended_time_namespace(seconds(600))) ::_exit(kNotPermitted);
    const auto after = clock.now();
    const auto passed = after.since_start - before.since_start;
    ::_exit(passed >= seconds(600) && passed < seconds(660) && after.utc - before.utc < seconds(60) ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  if (WEXITSTATUS(status) == kNotPermitted) GTEST_SKIP() << "this user may not create a time namespace";
  EXPECT_EQ(status, 0);
}

TEST(CivilTime, IsUtcInWholeSeconds) {
  EXPECT_EQ(civil_time(kVirtualEpoch), "2026-01-01T00:00:00Z");
  EXPECT_EQ(civil_time(kVirtualEpoch + std::chrono::milliseconds(1999)), "2026-01-01T00:00:01Z");
  EXPECT_EQ(civil_time(seconds(951'782'400)), "2000-02-29T00:00:00Z");
}

TEST(Spoken, OmitsLeadingZeros) {
  EXPECT_EQ(format_duration(seconds(0)), "0 s");
  EXPECT_EQ(format_duration(seconds(59)), "59 s");
  EXPECT_EQ(format_duration(seconds(61)), "1 min 01 s");
  EXPECT_EQ(format_duration(seconds(67'200)), "18 h 40 min 00 s");
}

}  // namespace
}  // namespace gyrotherm
