// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/host_time.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Arrival times of frames that an adapter forwards every 16 ms.
class BurstyLine {
 public:
  explicit BurstyLine(double frames_a_second) : rate_(frames_a_second) {}
  /// Returns the number of the newest frame at that time.
  [[nodiscard]] std::int64_t newest(double time_s) const {
    auto frame = static_cast<std::int64_t>(time_s * rate_);
    while (came_s(frame) > time_s) --frame;
    return frame;
  }
  [[nodiscard]] Duration came(std::int64_t frame) const { return from_seconds(came_s(frame)); }

 private:
  [[nodiscard]] double came_s(std::int64_t frame) const {
    constexpr double kBurst_s = 0.016;
    return std::ceil(static_cast<double>(frame) / rate_ / kBurst_s) * kBurst_s;
  }
  double rate_;
};

TEST(HostInterval, SmoothsRegularFrames) {
  for (const double rate : {0.97, 97.3, 100.0, 1000.0, 1028.0}) {
    const BurstyLine line(rate);
    HostInterval intervals(true);
    auto before = line.newest(2);
    const auto from = line.came(before);
    intervals.start_at(from);
    Duration sum{};
    for (int second = 3; second < 600; ++second) {
      const bool late = second == 300;
      const auto newest = line.newest(second + (late ? 2.51 : 0.001));
      // The frames of the late second are counted already.
      if (newest <= before) continue;
      const auto frames = static_cast<std::uint64_t>(newest - before);
      const auto interval = intervals.next(frames, line.came(newest));
      ASSERT_TRUE(interval) << rate << " frames a second, " << second;
      const double true_s = static_cast<double>(frames) / rate;
      EXPECT_NEAR(to_seconds(*interval), true_s, (second < 60 ? 0.0165 : 1e-3) * true_s)
          << rate << " frames a second, " << second;
      sum += *interval;
      EXPECT_NEAR(to_seconds(sum), to_seconds(line.came(newest) - from), 0.0165) << "it stays the host's time";
      before = newest;
    }
  }
}

TEST(HostInterval, IsExactWithoutDelays) {
  HostInterval intervals(true);
  intervals.start_at(seconds(7));
  Duration now = seconds(7);
  for (const int tenths : {10, 10, 35, 5, 10}) {
    now += milliseconds(100 * tenths);
    EXPECT_EQ(intervals.next(static_cast<std::uint64_t>(tenths), now), milliseconds(100 * tenths));
  }
}

TEST(HostInterval, UsesArrivalTimesOfIrregularFrames) {
  HostInterval intervals(false);
  intervals.start_at(seconds(1));
  EXPECT_EQ(intervals.next(3, milliseconds(1700)), milliseconds(700));
  EXPECT_EQ(intervals.next(1, milliseconds(3600)), milliseconds(1900));
  EXPECT_FALSE(intervals.next(1, milliseconds(3600))) << "no time has passed";
}

TEST(HostInterval, IsEmptyIfFramesAreMissing) {
  const auto after_three_seconds = [] {
    HostInterval intervals(true);
    intervals.start_at(seconds(0));
    for (int second = 1; second <= 3; ++second) EXPECT_TRUE(intervals.next(100, seconds(second)));
    return intervals;
  };
  auto intervals = after_three_seconds();
  EXPECT_FALSE(intervals.next(70, seconds(4)));
  intervals = after_three_seconds();
  EXPECT_FALSE(intervals.next(130, seconds(4)));
  intervals = after_three_seconds();
  EXPECT_TRUE(intervals.next(90, seconds(4))) << "a line may be a tenth of a second late";
  intervals = after_three_seconds();
  intervals.start_at(seconds(9));
  EXPECT_EQ(intervals.next(100, seconds(10)), seconds(1)) << "the rate is still known";
  EXPECT_FALSE(intervals.next(10, seconds(11)));
}

/// Returns the pace that FramePace reports after each second with that many frames instead of 1000.
std::vector<std::optional<double>> told(double frames_a_second, int seconds_long) {
  FramePace pace(1000);
  pace.start_at(seconds(0));
  std::vector<std::optional<double>> all;
  for (int second = 1; second <= seconds_long; ++second) {
    const auto jitter = milliseconds(7 * second % 17);
    pace.add(from_seconds(frames_a_second / 1000), seconds(second) + jitter);
    all.push_back(pace.find_deviating_pace());
  }
  return all;
}

TEST(FramePace, ReportsDeviatingRate) {
  for (const double rate : {50.0, 100.0, 500.0, 900.0, 1100.0, 2000.0, 10'000.0}) {
    const auto all = told(rate, 20);
    EXPECT_FALSE(all.front()) << "what a line has held back is not judged";
    for (std::size_t i = 15; i < all.size(); ++i) {
      ASSERT_TRUE(all[i]) << rate << " after " << i << " s";
      EXPECT_NEAR(*all[i], rate / 1000, 0.02 * rate / 1000) << "after " << i << " s";
    }
    if (rate <= 100 || rate >= 2000) {
      EXPECT_TRUE(all[2]) << rate << ": nothing of it is good";
    }
  }
}

TEST(FramePace, AcceptsDescribedRate) {
  for (const double rate : {970.0, 1000.0, 1030.0})
    for (const auto& other : told(rate, 1000)) ASSERT_FALSE(other) << rate << ' ' << *other;
}

TEST(FramePace, ToleratesOneLateRead) {
  FramePace pace(1000);
  pace.start_at(seconds(0));
  for (int second = 1; second < 100; ++second) {
    const auto late = second == 50 ? milliseconds(700) : second == 51 ? milliseconds(-700) : milliseconds(0);
    pace.add(seconds(1) - late, seconds(second));
    EXPECT_FALSE(pace.find_deviating_pace()) << second;
  }
}

TEST(FramePace, AcceptsCorrectedRate) {
  FramePace pace(1000);
  pace.start_at(seconds(0));
  for (int second = 1; second <= 60; ++second) pace.add(second < 10 ? milliseconds(100) : seconds(1), seconds(second));
  EXPECT_FALSE(pace.find_deviating_pace());
}

}  // namespace
}  // namespace gyrotherm::drivers
