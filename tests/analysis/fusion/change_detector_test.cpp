// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/change_detector.hpp"

#include <limits>

#include "analysis/fusion/rate_fusion.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

constexpr double kHop_deg_per_h = 0.01;
constexpr double kSecond_deg_per_h = 0.018;  ///< noise of a second: an angle random walk of 3e-4 °/√h

ChangeDetector detector(int dimension, double shift, double false_alarms_per_h) {
  auto made = ChangeDetector::make(
      {.dimension = dimension, .shift = shift, .false_alarms_per_h = false_alarms_per_h, .interval_s = 1});
  EXPECT_TRUE(made) << text(made.error());
  return *made;
}

/// 20 seeds of ten hours each, at six false alarms an hour: 1200 are expected, ± 35. As a bound, none of the seeds may
/// be further than four of its own spreads from 60.
TEST(ChangeDetector, AlarmsByChanceAsOftenAnHourAsItSays) {
  constexpr double kPerHour = 6, kHours = 10;
  for (const int dimension : {1, 3}) {
    int alarms = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      Draws draws(static_cast<std::uint64_t>(seed));
      ChangeDetector changes = detector(dimension, 0.4, kPerHour);
      int of_seed = 0;
      for (int second = 0; second < static_cast<int>(kHours * 3600); ++second)
        of_seed += changes.push(draws.normal(dimension)) ? 1 : 0;
      EXPECT_NEAR(of_seed, kPerHour * kHours, 4 * std::sqrt(kPerHour * kHours)) << "seed " << seed;
      alarms += of_seed;
    }
    const double expected = kPerHour * kHours * kSeeds;
    EXPECT_NEAR(alarms, expected, 4 * std::sqrt(expected)) << dimension;
  }
}

/// A dodecahedron's parity sees √½ of a hop: 0.39 of the noise of a second. With a false alarm in a thousand hours
/// the limit is 44; the hop is found and its axis named within some minutes.
TEST(ChangeDetector, FindsAHopThatIsSmallerThanTheNoiseOfASecond) {
  const Geometry geometry = made_of(dodecahedron_axes(kSecond_deg_per_h));
  const Gains gains = gains_of(geometry);
  const FaultTest test = parity_test(gains, geometry);
  const double shift = kHop_deg_per_h * test.effects.col(0).norm();
  double delays = 0;
  int named = 0;
  constexpr int kQuiet = 1800;
  const ChangeDetector fresh = detector(3, shift, 1e-3);
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    ChangeDetector changes = fresh;
    const Eigen::Index hopped = seed % 6;
    std::optional<Change> change;
    int second = 0;
    for (; !change && second < kQuiet + 3600; ++second) {
      Eigen::VectorXd readings = geometry.directions * Eigen::Vector3d(5, -8, 3) + draws.with(geometry.covariance);
      if (second >= kQuiet) readings(hopped) += kHop_deg_per_h;
      change = changes.push(gains.parity * readings);
    }
    ASSERT_TRUE(change) << "seed " << seed;
    ASSERT_GT(second, kQuiet) << "seed " << seed << ": a false alarm";
    delays += second - kQuiet;
    const auto isolation = isolate(test, change->root_sum());
    ASSERT_TRUE(isolation);
    named += isolation->candidate == hopped ? 1 : 0;
    EXPECT_EQ(isolation->candidate.value_or(hopped), hopped) << "seed " << seed;
    const double root = std::sqrt(change->steps);
    EXPECT_NEAR(isolation->size / root, kHop_deg_per_h, 4 * isolation->size_std / root) << "seed " << seed;
  }
  const double expected = fresh.limit() / (shift - fresh.slack());
  EXPECT_NEAR(delays / kSeeds, expected, 0.3 * expected) << "the sum does not start at 0";
  EXPECT_LT(delays / kSeeds, 300);
  EXPECT_GE(named, 19);
}

TEST(ChangeDetector, PassesOverWhatIsMissing) {
  ChangeDetector changes = detector(2, 1, 1);
  EXPECT_FALSE(changes.push(Eigen::Vector2d(2, 0)));
  const double level = changes.level();
  EXPECT_NEAR(level, 1.5, 1e-12);
  EXPECT_FALSE(changes.push(Eigen::Vector2d(std::numeric_limits<double>::quiet_NaN(), 0)));
  EXPECT_EQ(changes.level(), level);
  EXPECT_FALSE(changes.push(Eigen::Vector2d(-1.4, 0))) << "within the slack: it begins anew";
  EXPECT_EQ(changes.level(), 0);
}

TEST(ChangeDetector, BeginsAnewAfterAnAlarmAndSaysTheMean) {
  ChangeDetector changes = detector(2, 1, 1);
  int steps = 0;
  std::optional<Change> change;
  while (!change) {
    ++steps;
    change = changes.push(Eigen::Vector2d(0, -2));
  }
  EXPECT_EQ(change->steps, steps);
  EXPECT_EQ(steps, std::floor(changes.limit() / 1.5) + 1);
  EXPECT_TRUE(change->mean.isApprox(Eigen::Vector2d(0, -2)));
  EXPECT_EQ(changes.level(), 0);
}

TEST(ChangeDetector, RefusesWhatCannotBe) {
  const auto fails = [](const ChangeOptions& options) {
    const auto made = ChangeDetector::make(options);
    return !made && made.error().kind == FaultKind::usage;
  };
  EXPECT_TRUE(fails({.dimension = 0, .shift = 1, .false_alarms_per_h = 1}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 0, .false_alarms_per_h = 1}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 1, .false_alarms_per_h = 0}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 1, .false_alarms_per_h = 1000}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 1, .false_alarms_per_h = 1e-9}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = std::nan(""), .false_alarms_per_h = 1}));
}

}  // namespace
}  // namespace gyrotherm::fusion
