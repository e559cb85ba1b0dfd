// SPDX-License-Identifier: Apache-2.0
/// Each interlock by itself: the cause that raises it, its reaction, and values that do not raise it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/sequencer/run/interlock_bench.hpp"

namespace gyrotherm::run {
namespace {

using Bench = InterlockBench;

TEST(InterlockId, RaisesOneAlarmUntilCauseEnds) {
  Bench bench;
  bench.chamber().activity = ChamberActivity::door_open;
  bench.seconds(100);
  EXPECT_EQ(bench.alarms, 1);
  for (int i = 0; i < 20; ++i) {  // a swinging door
    bench.chamber().activity = i % 2 ? ChamberActivity::door_open : ChamberActivity::running;
    bench.seconds(4);
  }
  EXPECT_EQ(bench.alarms, 1);
  bench.chamber().activity = ChamberActivity::running;
  bench.seconds(9);
  EXPECT_EQ(active_faults(bench.memory).size(), 1u);
  bench.seconds(1);
  EXPECT_EQ(bench.over, 1);
  EXPECT_TRUE(active_faults(bench.memory).empty());
}

TEST(InterlockId, AppliesLimitsOfEachThermometer) {
  Bench bench;
  bench.limits.thermometers.assign(9, {});
  bench.limits.thermometers[4] = {{-10}, {21.5}};
  EXPECT_EQ(bench.seconds_until(interlocks::Reaction::abort), 2);
  bench = {};
  bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  bench.thermometer(8, -61);
  EXPECT_EQ(bench.seconds(2).cause, "thermometer shell reads -61.00 °C, outside -60 … 100 °C");
}

TEST(InterlockId, IgnoresSpikeOfOneSample) {
  Bench bench;
  for (int i = 0; i < 100; ++i) {
    bench.thermometer(2, i % 5 ? 22 : 850);
    ASSERT_LT(bench.second().reaction, interlocks::Reaction::abort);
  }
}

TEST(InterlockId, SuspendsWithinTenSecondsWithTooFewThermometers) {
  Bench bench;
  bench.limits.thermometers_needed = 8;
  bench.sample.thermometers[0].value = silence();
  EXPECT_EQ(bench.seconds_until(interlocks::Reaction::suspend, 100), -1);
  bench.sample.thermometers[1].value = silence();
  EXPECT_LE(bench.seconds_until(interlocks::Reaction::suspend), 10);
  EXPECT_EQ(bench.second().cause, "7 thermometers answer, 8 are needed for 6 s");
}

TEST(InterlockId, SuspendsWhenAirChangesFasterThanClosedChamberCan) {
  Bench bench;
  bench.seconds(70);
  for (int i = 0; i < 60; ++i) bench.chamber().air = bench.chamber().air + Kelvins{0.32}, bench.second();
  EXPECT_FALSE(bench.has(interlocks::InterlockId::air_rate)) << "19.2 °C in a minute";
  for (int i = 0; i < 60; ++i) bench.chamber().air = bench.chamber().air + Kelvins{0.36}, bench.second();
  EXPECT_TRUE(bench.has(interlocks::InterlockId::air_rate)) << "21.6 °C in a minute";
}

TEST(InterlockId, SuspendsWhenUnitChangesTooFast) {
  Bench bench;
  bench.limits.thermometers_fastest = {1};
  bench.seconds(70);
  interlocks::InterlockDemand demand;
  for (int i = 0; i < 70; ++i) {
    for (std::size_t t = 0; t < 9; ++t) bench.thermometer(t, 22 + 0.02 * i);
    demand = bench.second();
  }
  EXPECT_EQ(demand.reaction, interlocks::Reaction::suspend);
  EXPECT_TRUE(bench.has(interlocks::InterlockId::thermometer_rate));
}

TEST(InterlockId, WarnsOfThermometerFarFromOthers) {
  Bench bench;
  bench.limits.disagreement = {10};
  bench.thermometer(3, 33);
  EXPECT_EQ(bench.seconds(59).reaction, interlocks::Reaction::go_on);
  EXPECT_EQ(bench.seconds(2).reaction, interlocks::Reaction::warn);
  EXPECT_TRUE(bench.has(interlocks::InterlockId::disagreement));
}

TEST(InterlockId, AcceptsThermometerBetweenOthersAndAir) {
  for (const bool is_cooling : {true, false}) {
    Bench bench;
    bench.limits.disagreement = {10};
    bench.limits.thermometers_fastest = {1e5};
    const double sign = is_cooling ? 1 : -1;
    bench.chamber().air = {22 - 60 * sign};
    bench.thermometer(8, 22 - 45 * sign);
    bench.seconds(200);
    EXPECT_FALSE(bench.has(interlocks::InterlockId::disagreement)) << "the shell follows the air first";
    bench.thermometer(8, 22 - 75 * sign);
    bench.seconds(70);
    EXPECT_TRUE(bench.has(interlocks::InterlockId::disagreement)) << "above the air temperature";
    bench.thermometer(8, 22 - 45 * sign);
    bench.seconds(70);
    EXPECT_FALSE(bench.has(interlocks::InterlockId::disagreement));
    bench.sample.chamber.value = silence();
    bench.seconds(70);
    EXPECT_TRUE(bench.has(interlocks::InterlockId::disagreement)) << "without the air, only the others count";
  }
}

/// With three thermometers, a high reading lies between the others and their median in the same way as a low one.
TEST(InterlockId, NamesWrongThermometerOfThree) {
  for (const double wrong : {-60.0, 90.0}) {
    Bench bench;
    bench.limits.disagreement = {40};
    bench.sample.thermometers.resize(3);
    for (std::size_t t = 0; t < 3; ++t) bench.thermometer(t, 22 + 0.1 * static_cast<double>(t));
    bench.thermometer(0, wrong);
    bench.seconds(61);
    ASSERT_TRUE(bench.has(interlocks::InterlockId::disagreement)) << wrong;
    EXPECT_EQ(bench.memory.most_affected_watch(interlocks::InterlockId::disagreement).column, 0U) << wrong;
  }
}

TEST(InterlockId, WarnsOfStuckThermometerWhileOthersMove) {
  Bench bench;
  bench.seconds(300);
  EXPECT_FALSE(bench.has(interlocks::InterlockId::stuck)) << "nothing moves";
  for (int i = 0; i < 200; ++i) {
    for (std::size_t t = 1; t < 9; ++t) bench.thermometer(t, 22 + 0.01 * i);
    bench.second();
  }
  EXPECT_TRUE(bench.has(interlocks::InterlockId::stuck));
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::warn);
}

TEST(InterlockId, AbortsAfterJumpOfChamberSensorThoughReadingReturns) {
  Bench bench;
  bench.seconds(100);
  bench.chamber().air = {32.5};
  EXPECT_EQ(bench.seconds(20).reaction, interlocks::Reaction::go_on);
  bench.chamber().air = {31};
  bench.seconds(9);
  EXPECT_EQ(bench.seconds_until(interlocks::Reaction::abort, 40), 1);
  EXPECT_TRUE(bench.has(interlocks::InterlockId::chamber_sensor));
}

TEST(InterlockId, DetectsJumpAtAnyTemperatureOfUnit) {
  Bench bench;
  for (std::size_t i = 0; i < 9; ++i) bench.thermometer(i, 35);
  EXPECT_EQ(bench.seconds(3000).reaction, interlocks::Reaction::go_on) << "it warms itself";
  auto small = bench, large = bench;
  small.chamber().air = {10.5};
  EXPECT_LT(small.seconds(300).reaction, interlocks::Reaction::abort);
  large.chamber().air = {9.5};
  EXPECT_EQ(large.seconds_until(interlocks::Reaction::abort, 40), 30);
}

TEST(InterlockId, CountsJumpInTwoStepsAndIgnoresReturningJump) {
  Bench bench;
  bench.seconds(10);
  auto spike = bench;
  bench.chamber().air = {26};
  bench.second();
  bench.chamber().air = {32};
  EXPECT_EQ(bench.seconds_until(interlocks::Reaction::abort, 40), 30);
  spike.chamber().air = {45};
  spike.seconds(20);
  spike.chamber().air = {20};
  EXPECT_LT(spike.seconds(100).reaction, interlocks::Reaction::abort);
  EXPECT_FALSE(spike.has(interlocks::InterlockId::chamber_sensor));
}

/// The air falls to the ambient temperature within a minute, also while its reading is lost for some seconds.
TEST(InterlockId, OpenDoorIsNoContradiction) {
  Bench bench;
  double air = 85;
  for (int i = 0; i < 300; ++i) {
    air += (22 - air) / 60;
    bench.sample.chamber.value = ChamberState{{air}, {85}};
    bench.around.sent = Celsius{85};
    if (i > 20 && i < 25) bench.sample.chamber.value = failure(FaultKind::timeout, "chamber", "no reply");
    ASSERT_LT(bench.second().reaction, interlocks::Reaction::abort) << i;
  }
}

TEST(InterlockId, LaggingUnitIsNoContradiction) {
  Bench bench;
  bench.seconds(700);
  // A ramp of 5 °C/min, and a unit under test that hardly follows.
  for (int i = 0; i < 600; ++i) {
    bench.chamber().air = bench.chamber().air + Kelvins{5.0 / 60};
    bench.around.sent = bench.chamber().set_point = bench.chamber().air;
    ASSERT_NE(bench.second().reaction, interlocks::Reaction::abort) << i;
  }
}

TEST(InterlockId, AirThermometersMayContradictChamberAtAnyTime) {
  Bench bench;
  bench.limits.air_thermometers = {8};
  bench.thermometer(8, 31);
  EXPECT_EQ(bench.seconds_until(interlocks::Reaction::abort, 40), 30);
}

TEST(InterlockId, SuspendsAfterFiveMinutesWhenAirDoesNotFollow) {
  Bench bench;
  bench.seconds(10);
  bench.around.sent = bench.chamber().set_point = {40};
  const auto found = bench.seconds_until(interlocks::Reaction::suspend, 3600);
  EXPECT_GT(found, 300);
  EXPECT_LT(found, 1200);
  EXPECT_TRUE(bench.has(interlocks::InterlockId::following));
}

TEST(InterlockId, AcceptsAirThatFollowsWithLag) {
  Bench bench;
  double set_point = 20, air = 20, uut = 20;
  for (int i = 0; i < 4000; ++i) {
    if (i > 300 && i < 1000) set_point += 5.0 / 60;
    air += (set_point - air) / 240;  // twice as slow as predicted
    bench.around.sent = bench.chamber().set_point = {set_point};
    bench.chamber().air = {air};
    for (std::size_t t = 0; t < 9; ++t) bench.thermometer(t, uut += (air - uut) / 3600 / 9);
    ASSERT_EQ(bench.second().reaction, interlocks::Reaction::go_on) << i;
  }
}

TEST(InterlockId, AbortsNearLimitWhenAirDoesNotFollow) {
  Bench bench;
  bench.limits.air_highest = {21};
  bench.seconds(10);
  bench.around.sent = bench.chamber().set_point = {0};
  EXPECT_NE(bench.seconds_until(interlocks::Reaction::abort, 1200), -1);
}

TEST(InterlockId, DetectsForeignSetPointAtSecondPoll) {
  Bench bench;
  bench.seconds(10);
  bench.chamber().set_point = {25};
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::go_on);
  const auto demand = bench.second();
  EXPECT_EQ(demand.reaction, interlocks::Reaction::suspend);
  EXPECT_EQ(demand.cause,
            "changed by another program or at its panel: the chamber has the set point 25 °C instead of 20 °C");
  EXPECT_EQ(bench.seconds(10'000).reaction, interlocks::Reaction::suspend) << "while the foreign set point is active";
}

TEST(InterlockId, RoundsSetPointsInItsText) {
  Bench bench;
  bench.around.sent = bench.chamber().set_point = {20 + 1.0 / 3};
  bench.seconds(10);
  bench.chamber().set_point = {-12.3456};
  bench.second();
  EXPECT_EQ(bench.second().cause,
            "changed by another program or at its panel: the chamber has the set point -12.35 °C instead of 20.33 °C");
}

TEST(InterlockId, AcceptsSetPointRoundedByController) {
  Bench bench;
  bench.chamber().set_point = {20.09};
  EXPECT_EQ(bench.seconds(100).reaction, interlocks::Reaction::go_on);
}

TEST(InterlockId, TreatsChangedStateAfterSilenceAsRestart) {
  Bench bench;
  bench.around.sent = bench.chamber().set_point = {60};
  bench.seconds(10);
  const auto state = bench.chamber();
  bench.sample.chamber.value = silence();
  bench.seconds(3);
  bench.sample.chamber.value = state;
  bench.chamber().set_point = {20};
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::suspend);
  EXPECT_TRUE(bench.has(interlocks::InterlockId::restarted));
  EXPECT_FALSE(bench.has(interlocks::InterlockId::foreign_set_point));
  bench.seconds(10);
  EXPECT_FALSE(bench.has(interlocks::InterlockId::foreign_set_point)) << "one alarm per cause";
}

TEST(InterlockId, ForeignSetPointThatOutlastsSilenceIsNoRestart) {
  Bench bench;
  bench.seconds(10);
  bench.chamber().set_point = {25};
  bench.seconds(2);
  const auto state = bench.chamber();
  bench.sample.chamber.value = silence();
  EXPECT_EQ(bench.seconds(20).reaction, interlocks::Reaction::suspend);
  bench.sample.chamber.value = state;
  bench.seconds(10);
  EXPECT_TRUE(bench.has(interlocks::InterlockId::foreign_set_point));
  EXPECT_FALSE(bench.has(interlocks::InterlockId::restarted)) << "the run does not overwrite it";
}

TEST(InterlockId, AcceptsChamberUnchangedAfterSilence) {
  Bench bench;
  const auto state = bench.chamber();
  bench.sample.chamber.value = silence();
  bench.seconds(3);
  bench.sample.chamber.value = state;
  EXPECT_EQ(bench.seconds(10).reaction, interlocks::Reaction::go_on);
}

TEST(InterlockId, SuspendsWhenChamberIsSwitchedOff) {
  Bench bench;
  bench.chamber().activity = ChamberActivity::off;
  EXPECT_EQ(bench.seconds(2).reaction, interlocks::Reaction::suspend);
}

TEST(InterlockId, SuspendsAfterThreeRefusedSetPoints) {
  Bench bench;
  bench.around.refusals = 2;
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::go_on);
  bench.around.refusals = 3;
  bench.around.refusal = "it reads 20 after 21 was written";
  EXPECT_EQ(bench.second().cause, "the chamber refuses set points: it reads 20 after 21 was written");
}

TEST(InterlockId, HoldsAfterSleepOfMachine) {
  Bench bench;
  bench.around.missed = std::chrono::seconds(120);
  EXPECT_EQ(bench.second(std::chrono::seconds(121)).reaction, interlocks::Reaction::go_on);
  bench.around.missed = std::chrono::seconds(121);
  EXPECT_EQ(bench.second(std::chrono::seconds(122)).reaction, interlocks::Reaction::hold);
}

TEST(InterlockId, WarnsOfDelayedRecordUnlessPolicyIsStricter) {
  Bench bench;
  bench.around.backlog = std::chrono::seconds(60);
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::go_on);
  bench.around.backlog = std::chrono::seconds(61);
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::warn);
  bench.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::storage)] = interlocks::Reaction::hold;
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::hold);
  bench.around.backlog = {};
  bench.around.rows_dropped = true;
  EXPECT_EQ(bench.second().cause, "the record loses rows");
}

TEST(InterlockId, WarnsOfWallClockStepAndContinues) {
  Bench bench;
  bench.seconds(10);
  bench.sample.at.utc += std::chrono::milliseconds(49);
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::go_on);
  bench.sample.at.utc -= std::chrono::hours(1);
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::warn);
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::go_on) << "a step clears immediately";
  EXPECT_EQ(bench.alarms, 1);
}

TEST(InterlockId, AbortsWhenControllerLeavesItsProgram) {
  Bench bench;
  bench.around.program = "the controller has not carried out its program";
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::abort);
}

TEST(InterlockId, HasFixedReactionWhenUnitCouldBeDamaged) {
  for (const auto cause : {interlocks::InterlockId::air_limit, interlocks::InterlockId::thermometer_limit,
                           interlocks::InterlockId::chamber_alarm, interlocks::InterlockId::emergency_stop,
                           interlocks::InterlockId::deadline, interlocks::InterlockId::program}) {
    EXPECT_FALSE(interlock(cause).choosable) << name(cause);
    EXPECT_EQ(interlock(cause).usual, interlocks::Reaction::abort) << name(cause);
  }
}

TEST(InterlockId, RaisesNothingForNoise) {
  Bench bench;
  unsigned state = 1;
  const auto noise = [&state] {
    return (static_cast<double>((state = state * 1664525u + 1013904223u) >> 16) / 65536 - 0.5);
  };
  for (int i = 0; i < 20'000; ++i) {
    bench.chamber().air = {20 + 0.3 * noise()};
    for (std::size_t t = 0; t < 9; ++t) bench.thermometer(t, 22 + 0.1 * noise());
    bench.second();
  }
  EXPECT_EQ(bench.alarms, 0);
}

TEST(InterlockId, ReportsLostChannelByNameAndContinues) {
  Bench bench;
  bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  bench.sample.thermometers[1].value = silence();
  bench.sample.thermometers[8].value = silence();
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::warn);
  EXPECT_EQ(active_faults(bench.memory),
            (std::vector<std::string>{"no reading of thermometer B", "no reading of thermometer shell"}));
  EXPECT_EQ(bench.seconds(1000).reaction, interlocks::Reaction::warn);
  EXPECT_EQ(bench.alarms, 2);
}

TEST(InterlockId, NamesInstrumentOfManyLostChannels) {
  Bench bench;
  bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  bench.limits.instruments = {{.name = "thermometer 1", .columns = {0, 1, 2, 3}},
                              {.name = "thermometer 2", .columns = {4, 5, 6}}};
  for (std::size_t i = 0; i < 7; ++i) bench.sample.thermometers[i].value = silence();
  bench.second();
  EXPECT_EQ(active_faults(bench.memory),
            (std::vector<std::string>{"no reading of the 4 channels of thermometer 1",
                                      "no reading of thermometer E, thermometer F, thermometer G"}));
}

TEST(InterlockId, DistinguishesSlowScannerFromSilentOne) {
  for (const bool slow : {false, true}) {
    Bench bench;
    for (auto& reading : bench.sample.thermometers) reading.value = silence();
    if (slow) bench.sample.thermometers[4].value = failure(FaultKind::timeout, "E", "still busy after 900 ms");
    bench.second();
    const auto& text = bench.memory.most_affected_watch(interlocks::InterlockId::thermometers_lost).text;
    EXPECT_EQ(text, slow ? "every thermometer silent or too slow: still busy after 900 ms; a reading must take less "
                           "than a second"
                         : "every thermometer silent");
  }
}

TEST(InterlockId, SuspendsWhenAnalysisNeedsLostChannel) {
  Bench bench;
  bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  bench.limits.units = {{.name = "gyro", .thermometers = {0, 3}}};
  bench.sample.thermometers[1].value = silence();
  EXPECT_EQ(bench.seconds_until(interlocks::Reaction::suspend, 100), -1) << "B is not needed";
  bench.sample.thermometers[3].value = silence();
  EXPECT_EQ(bench.seconds_until(interlocks::Reaction::suspend, 100), 5);
  EXPECT_EQ(bench.memory.most_affected_watch(interlocks::InterlockId::needed_channel_lost).text,
            "no reading of thermometer D, which the analysis needs");
  bench.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::needed_channel_lost)] =
      interlocks::Reaction::warn;
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::warn) << "as the rig file specifies";
}

TEST(InterlockId, ReportsDamagedRecordAndMissingGuardImmediately) {
  Bench bench;
  bench.around.record_damage = "run.db was removed or moved by another program while it was being written";
  EXPECT_EQ(bench.second().reaction, interlocks::Reaction::warn);
  EXPECT_TRUE(bench.has(interlocks::InterlockId::record_damaged));
  bench.around.guard_troubles = {{"guard", "the guard has ended, and is replaced"}};
  bench.second();
  EXPECT_TRUE(bench.has(interlocks::InterlockId::unguarded));
  EXPECT_EQ(bench.alarms, 2);
}

/// An operator whose confirmation is required could otherwise never resume the run.
TEST(InterlockId, HoldsOnceForEachDamageOfRecord) {
  Bench bench;
  bench.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::record_damaged)] = interlocks::Reaction::hold;
  for (const auto* damage : {"run.db was removed", "run.2.db was removed"}) {
    bench.around.record_damage = damage;
    EXPECT_EQ(bench.second().reaction, interlocks::Reaction::hold) << damage;
    EXPECT_EQ(bench.seconds(100).reaction, interlocks::Reaction::warn);
  }
  EXPECT_EQ(bench.alarms, 2) << "one for each file; none clears";
}

/// On a lossy line the chamber's activity is known some seconds after its air.
TEST(InterlockId, TreatsChamberOffAfterSilenceAsRestartWhenStateIsLate) {
  Bench bench;
  bench.sample.chamber.value = silence();
  bench.second();
  bench.sample.chamber.value = ChamberState{{20}, {20}};
  bench.seconds(3);
  bench.chamber().activity = ChamberActivity::off;
  bench.second();
  EXPECT_GT(bench.memory.most_affected_watch(interlocks::InterlockId::restarted_off).samples, 0);
  EXPECT_EQ(bench.memory.most_affected_watch(interlocks::InterlockId::foreign_set_point).samples, 0);
}

}  // namespace
}  // namespace gyrotherm::run
