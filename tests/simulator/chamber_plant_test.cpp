// SPDX-License-Identifier: Apache-2.0
#include "simulator/chamber_plant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

PlantParameters shipped() { return laboratory_of_rig("virtual").plant; }

TEST(ChamberPlant, FollowsRampsOfQualificationWithinOneKelvin) {
  for (const double rate : {1.0, 2.0, 3.0, 5.0}) {
    ChamberPlant plant(shipped());
    double worst_k = 0;
    for (const double set_point : rate_cycle_c(rate)) {
      plant.step({set_point}, true);
      worst_k = std::max(worst_k, std::abs(plant.air().value - set_point));
    }
    EXPECT_LT(worst_k, 1.0) << rate << " °C/min";
    EXPECT_GT(worst_k, 0.01 * rate) << "the plant must have a lag";
  }
}

TEST(ChamberPlant, SettlesWithinFiveMinutesAfterSteepestRamp) {
  ChamberPlant plant(shipped());
  const auto cycle = rate_cycle_c(5);
  const std::size_t ramp_end = 7200 + 720;
  for (std::size_t t = 0; t < ramp_end + 7200; ++t) {
    plant.step({cycle[t]}, true);
    if (t < ramp_end + 300) continue;
    ASSERT_NEAR(plant.air().value, -40, 0.1) << t - ramp_end << " s after the ramp";
  }
}

TEST(ChamberPlant, CoolsMoreSlowlyInCold) {
  ChamberPlant plant(shipped());
  const auto seconds_to = [&](double target_c) {
    int seconds = 0;
    for (; plant.air().value > target_c; ++seconds) plant.step({-45}, true);
    return seconds;
  };
  (void)seconds_to(10);
  const int warm_s = seconds_to(0);
  (void)seconds_to(-30);
  const int cold_s = seconds_to(-40);
  EXPECT_GT(cold_s, 1.3 * warm_s);
  EXPECT_GT(cold_s, 60) << "the cooling rate is limited";
}

TEST(ChamberPlant, DoesNotWindUpWhileOutputIsAtLimit) {
  ChamberPlant plant(shipped());
  double lowest_c = 20;
  for (int t = 0; t < 3600; ++t) {
    plant.step({-40}, true);
    lowest_c = std::min(lowest_c, plant.air().value);
  }
  EXPECT_GT(lowest_c, -41);
}

TEST(ChamberPlant, DriftsTowardsSurroundingsWhenSwitchedOff) {
  ChamberPlant plant(shipped());
  for (int t = 0; t < 3600; ++t) plant.step({-40}, true);
  for (int t = 0; t < 7 * 86400; ++t) plant.step({-40}, false);
  EXPECT_NEAR(plant.air().value, shipped().room_c, 0.01);
  EXPECT_NEAR(plant.output_percent(), 0, 1e-9);
}

TEST(ChamberPlant, KeepsVapourAsFrostUntilWallsAreWarm) {
  ChamberPlant plant(shipped());
  const auto pass = [&](double set_point, int hours) {
    for (int i = 0; i < 3600 * hours; ++i) plant.step({set_point}, true);
  };
  EXPECT_NEAR(plant.dew_point().value, 12.0, 0.2) << "50 % at 23 °C";
  EXPECT_NEAR(plant.humidity_percent(), 60, 1);
  pass(-30, 2);
  EXPECT_LT(condensation_point(plant.dew_point()).value, -29.5) << "saturated at the coldest surface";
  pass(20, 1);
  EXPECT_GT(plant.dew_point().value, 0) << "the frost has evaporated";
  PlantFaults open;
  open.door_open = true;
  pass(-30, 2);
  plant.inject(open);
  for (int i = 0; i < 60; ++i) plant.step({-30}, true);
  EXPECT_GT(condensation_point(plant.dew_point()).value, -28) << "humid air enters";
}

}  // namespace
}  // namespace gyrotherm::simulator
