// SPDX-License-Identifier: Apache-2.0
/// Limits act on k of the last 2 k readings, so that an intermittent cause in every second reading acts.
#include <gtest/gtest.h>

#include <functional>

#include "tests/sequencer/run/interlock_bench.hpp"

namespace gyrotherm::run {
namespace {

using interlocks::InterlockId;
using interlocks::Reaction;

/// Creates the cause in every `of`th second. Returns the number of seconds until the interlock acts, or −1 if it does
/// not act within `most`.
int seconds_until_action(InterlockBench bench, InterlockId id, int of, int most,
                         const std::function<void(InterlockBench&, bool)>& make) {
  make(bench, false);
  bench.seconds(100);
  for (int i = 1; i <= most; ++i) {
    make(bench, i % of == 1);
    bench.second();
    if (bench.has(id)) return i;
  }
  return -1;
}

void hot_thermometer(InterlockBench& bench, bool is_hot) { bench.thermometer(3, is_hot ? 180 : 22); }
void hot_air(InterlockBench& bench, bool is_hot) { bench.chamber().air = {is_hot ? 130.0 : 20.0}; }
void foreign(InterlockBench& bench, bool is_foreign) { bench.chamber().set_point = {is_foreign ? 65.0 : 20.0}; }

TEST(KOfN, ActsWhenEverySecondReadingExceedsLimit) {
  EXPECT_EQ(seconds_until_action({}, InterlockId::thermometer_limit, 2, 100, hot_thermometer), 3);
  EXPECT_EQ(seconds_until_action({}, InterlockId::air_limit, 2, 100, hot_air), 3);
  EXPECT_EQ(seconds_until_action({}, InterlockId::foreign_set_point, 2, 100, foreign), 3);
}

TEST(KOfN, ActsWhenEveryThirdButNotEveryFourthReadingExceedsLimit) {
  for (const auto& [id, make] :
       {std::pair(InterlockId::thermometer_limit, &hot_thermometer), std::pair(InterlockId::air_limit, &hot_air),
        std::pair(InterlockId::foreign_set_point, &foreign)}) {
    EXPECT_EQ(seconds_until_action({}, id, 3, 100, make), 4) << name(id);
    EXPECT_EQ(seconds_until_action({}, id, 4, 400, make), -1) << name(id);
  }
}

TEST(KOfN, DependsOnConfirmingSamples) {
  InterlockBench bench;
  bench.limits.confirming_samples = 5;
  EXPECT_EQ(seconds_until_action(bench, InterlockId::air_limit, 2, 100, hot_air), 9);
  EXPECT_EQ(seconds_until_action(bench, InterlockId::foreign_set_point, 2, 100, foreign), 9);
  bench.limits.confirming_samples = 1;
  EXPECT_EQ(seconds_until_action(bench, InterlockId::thermometer_limit, 50, 100, hot_thermometer), 1);
}

TEST(KOfN, LostReadingsDoNotResetCount) {
  const auto hot_or_lost = [](InterlockBench& bench, bool is_hot) {
    if (is_hot)
      bench.thermometer(3, 180);
    else
      bench.sample.thermometers[3].value = silence();
  };
  EXPECT_EQ(seconds_until_action({}, InterlockId::thermometer_limit, 20, 100, hot_or_lost), 21);
}

/// Half of the readings that arrive are too hot.
TEST(KOfN, LostReadingsAfterGoodOneDoNotCountAsGood) {
  for (const int lost : {1, 2, 5, 30})
    for (const auto id : {InterlockId::thermometer_limit, InterlockId::air_limit}) {
      InterlockBench bench;
      bench.seconds(100);
      const auto chamber = bench.sample.chamber;
      int acted = -1;
      for (int second = 0; second < 500 && acted < 0; ++second) {
        const int phase = second % (lost + 2);
        const bool is_hot = phase == 0;
        bench.thermometer(3, is_hot ? 180 : 22);
        bench.sample.chamber = chamber;
        if (id == InterlockId::air_limit) hot_air(bench, is_hot), bench.thermometer(3, 22);
        if (phase > 1) bench.sample.thermometers[3].value = silence();
        if (phase > 1) bench.sample.chamber.value = silence();
        bench.second();
        if (bench.has(id)) acted = second;
      }
      EXPECT_EQ(acted, lost + 2) << name(id) << ", " << lost << " lost";
    }
}

TEST(KOfN, ActsWhenCauseIsPresentForHalfOfTime) {
  InterlockBench bench;
  bench.limits.air_thermometers = {8};
  const auto sensor = [](InterlockBench& one, bool is_wrong) { one.thermometer(8, is_wrong ? 35 : 20); };
  EXPECT_NEAR(seconds_until_action(bench, InterlockId::chamber_sensor, 2, 200, sensor), 60, 1);
  const auto apart = [](InterlockBench& one, bool is_apart) { one.thermometer(8, is_apart ? 90 : 22); };
  EXPECT_NEAR(seconds_until_action({}, InterlockId::disagreement, 2, 400, apart), 120, 1);
  EXPECT_EQ(seconds_until_action({}, InterlockId::disagreement, 3, 1000, apart), -1);
}

/// The count restarts after an alarm has cleared.
TEST(KOfN, RestartsCountAfterAlarmCleared) {
  InterlockBench bench;
  bench.limits.disagreement = {10};
  bench.thermometer(3, 40);
  bench.seconds(70);
  bench.thermometer(3, 22);
  bench.seconds(20);
  bench.thermometer(3, 40);
  bench.seconds(59);
  EXPECT_FALSE(bench.has(InterlockId::disagreement));
  bench.seconds(2);
  EXPECT_TRUE(bench.has(InterlockId::disagreement));
}

}  // namespace
}  // namespace gyrotherm::run
