// SPDX-License-Identifier: Apache-2.0
/// Detection of instruments that no longer measure, and of behaviour that must not be taken for that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/sequencer/run/interlock_bench.hpp"

namespace gyrotherm::run {
namespace {

using interlocks::InterlockId;
using interlocks::Reaction;

/// Noise and resolution of an instrument.
struct Quality {
  double noise{}, resolution{};
};

/// A bench with noisy readings, as instruments have them.
class NoisyBench : public InterlockBench {
 public:
  explicit NoisyBench(Quality of_thermometers = {0.01, 0.01}, Quality of_air = {0.05, 0.01})
      : thermometers_(of_thermometers), air_(of_air) {
    limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
    limits.instruments = {{.name = "thermometer 1", .columns = {0, 1, 2, 3, 4, 5, 6, 7}},
                          {.name = "thermometer 2", .columns = {8}}};
    limits.units = {{.name = "gyro", .axes = {{"gyro", 0.1, DegreesPerHour{10.6}}}}};
  }

  /// Passes seconds at rest or on a ramp: everything moves by `step` K per second.
  void pass(int count, double step = 0) {
    for (int i = 0; i < count; ++i) {
      at_ += step;
      around.sent = chamber().set_point = {std::round(at_ * 100) / 100};
      if (!air_is_frozen) chamber().air = {read(at_, air_)};
      for (std::size_t t = 0; t < sample.thermometers.size(); ++t)
        if (!(t < 8 ? first_is_frozen : second_is_frozen) && sample.thermometers[t].value)
          thermometer(t, read(at_ + 2 + 0.1 * static_cast<double>(t) + (t == 3 ? fourth_is_off_by : 0), thermometers_));
      second();
    }
  }

  bool first_is_frozen = false, second_is_frozen = false, air_is_frozen = false;
  double fourth_is_off_by = 0;  ///< K

 private:
  double read(double value, const Quality& quality) {
    if (quality.noise > 0) value += std::normal_distribution<>(0, quality.noise)(random_);
    return quality.resolution > 0 ? std::round(value / quality.resolution) * quality.resolution : value;
  }

  Quality thermometers_, air_;
  std::mt19937 random_{1};
  double at_ = 20;
};

TEST(Frozen, FindsInstrumentWhoseChannelsAreAllIdentical) {
  NoisyBench bench;
  bench.pass(600);
  bench.first_is_frozen = true;
  bench.pass(59);
  EXPECT_FALSE(bench.has(InterlockId::frozen));
  bench.pass(10);
  EXPECT_TRUE(bench.has(InterlockId::frozen));
  EXPECT_EQ(bench.raised, std::vector<std::string>{"frozen thermometer 1"});
  bench.first_is_frozen = false;
  bench.pass(20);
  EXPECT_EQ(bench.cleared, std::vector<std::string>{"frozen thermometer 1"});
}

TEST(Frozen, FindsSingleChannelAndFineAndSlowInstruments) {
  for (const auto& quality : {Quality{0.01, 0.01}, Quality{0.3, 1e-6}, Quality{0.002, 0.001}}) {
    NoisyBench bench(quality);
    bench.pass(900);
    bench.second_is_frozen = true;
    bench.pass(300);
    EXPECT_EQ(bench.raised, std::vector<std::string>{"frozen thermometer 2"}) << quality.noise;
  }
}

TEST(Frozen, FindsInstrumentOnRampDespiteLostReadings) {
  NoisyBench bench;
  bench.pass(600);
  bench.first_is_frozen = true;
  for (int i = 0; i < 40; ++i) {
    const auto known = bench.sample.thermometers;
    bench.pass(2, 0.08);
    for (std::size_t t = 0; t < 8; ++t) bench.sample.thermometers[t].value = silence();
    bench.pass(1, 0.08);
    bench.sample.thermometers = known;
  }
  EXPECT_TRUE(bench.has(InterlockId::frozen));
}

TEST(Frozen, FindsAirOfChamber) {
  NoisyBench bench;
  bench.pass(900);
  bench.air_is_frozen = true;
  bench.pass(400);
  EXPECT_EQ(bench.raised, std::vector<std::string>{"frozen chamber"});
}

/// A scanner that is dead from the first second has never shown noise.
TEST(Frozen, FindsInstrumentThatNeverChangedAfterAirMoved) {
  NoisyBench bench;
  bench.first_is_frozen = true;
  bench.pass(600);
  EXPECT_FALSE(bench.has(InterlockId::frozen));
  bench.pass(200, 0.08);
  EXPECT_TRUE(bench.has(InterlockId::frozen));
}

/// The noise is not known yet, because the set point has not been constant for a minute.
TEST(Frozen, FindsInstrumentThatStopsDuringFirstRamp) {
  for (const auto& quality : {Quality{0.01, 0.01}, Quality{0, 0.01}, Quality{0, 0.1}, Quality{0.005, 0.1}})
    for (const double step : {0.05, -0.05}) {
      NoisyBench bench(quality, {0.05, 0.1});
      bench.pass(10);
      bench.pass(50, step);
      bench.first_is_frozen = true;
      bench.pass(50, step);
      EXPECT_FALSE(bench.has(InterlockId::frozen)) << "frozen_after has not passed";
      bench.pass(20, step);
      EXPECT_EQ(std::ranges::count(bench.raised, "frozen thermometer 1"), 1)
          << quality.noise << " K, in steps of " << quality.resolution;
      EXPECT_EQ(std::ranges::count(bench.raised, "frozen thermometer 2"), 0);
    }
}

TEST(Frozen, IgnoresInstrumentThatStopsWithTheAir) {
  for (const auto& quality : {Quality{0.005, 0.1}, Quality{0, 0.1}, Quality{0, 0.01}, Quality{0, 0}, Quality{0, 1}}) {
    NoisyBench bench(quality, {0.05, 0.1});
    for (const double step : {0.05, -0.05, 0.002, -0.01, 0.1}) {
      bench.pass(300, step);
      bench.pass(600);
    }
    for (int i = 0; i < 20; ++i) bench.pass(100, i % 2 == 0 ? 0.03 : -0.03);
    EXPECT_EQ(std::ranges::count(bench.raised, "frozen thermometer 1"), 0) << quality.resolution;
    EXPECT_EQ(std::ranges::count(bench.raised, "frozen thermometer 2"), 0) << quality.resolution;
  }
}

TEST(Frozen, IgnoresCoarseAndNoiselessInstrumentsDuringSoak) {
  for (const auto& quality : {Quality{0.005, 0.1}, Quality{0.02, 0.1}, Quality{0, 0.1}, Quality{0, 0}}) {
    NoisyBench bench(quality, quality);
    for (const double step : {0.05, -0.08}) {
      bench.pass(2000);
      bench.pass(400, step);
      bench.pass(8000);
    }
    EXPECT_FALSE(bench.has(InterlockId::frozen)) << quality.noise << " K, in steps of " << quality.resolution;
    EXPECT_EQ(std::ranges::count(bench.raised, "frozen chamber"), 0) << quality.noise;
    EXPECT_EQ(std::ranges::count(bench.raised, "frozen thermometer 1"), 0) << quality.noise;
  }
}

/// Air with a resolution of 0.1 K, noisy on ramps because of a fan, and quiet at holds.
TEST(Frozen, IgnoresAirThatIsConstantAtHolds) {
  NoisyBench noisy({0.01, 0.01}, {0.15, 0.1});
  NoisyBench bench({0.01, 0.01}, {0.01, 0.1});
  bench.pass(300);
  noisy.pass(1);
  for (int i = 0; i < 600; ++i) {
    bench.chamber().air = {std::round((20 + 0.1 * i + (i % 2 ? 0.3 : -0.3)) * 10) / 10};
    bench.around.sent = bench.chamber().set_point = {20 + 0.1 * i};
    bench.second();
  }
  bench.chamber().air = bench.chamber().set_point;
  bench.air_is_frozen = true;
  for (int i = 0; i < 3600; ++i) bench.second();
  EXPECT_EQ(std::ranges::count(bench.raised, "frozen chamber"), 0);
}

TEST(Frozen, ExcludesReadingsFromLimitsAndThermometerCount) {
  NoisyBench bench;
  bench.limits.thermometers_needed = 2;
  bench.pass(600);
  bench.first_is_frozen = true;
  bench.pass(80);
  EXPECT_TRUE(bench.has(InterlockId::thermometers_lost));
  EXPECT_FALSE(bench.has(InterlockId::channel_lost)) << "frozen reports it";
  bench.limits.thermometers_highest = {21};
  bench.limits.thermometers.assign(9, {{-60}, {21}});  // the frozen ones read more
  bench.limits.thermometers[8] = {{-60}, {100}};
  bench.pass(10);
  EXPECT_FALSE(bench.has(InterlockId::thermometer_limit));
}

/// Sets the counts of each axis for some seconds.
void count(InterlockBench& bench, const std::vector<std::int64_t>& pulses, int seconds) {
  bench.sample.units[0].count.value = GyroCount{pulses, kSecond};
  bench.seconds(seconds);
}

TEST(GyroDead, FindsAxisWithoutCountsDespiteEarthRate) {
  NoisyBench bench;
  count(bench, {106}, 100);
  count(bench, {0}, 59);
  EXPECT_FALSE(bench.has(InterlockId::gyro_dead));
  count(bench, {0}, 1);
  EXPECT_EQ(bench.raised, std::vector<std::string>{"gyro_dead gyro"});
  EXPECT_EQ(bench.second().reaction, Reaction::suspend);
  count(bench, {106}, 12);
  EXPECT_EQ(bench.cleared, std::vector<std::string>{"gyro_dead gyro"});
}

TEST(GyroDead, FindsOneAxisOfThree) {
  NoisyBench bench;
  bench.limits.units = {{.name = "u1",
                         .axes = {{"u1.x", 0.1, DegreesPerHour{10.6}},
                                  {"u1.y", 0.1, DegreesPerHour{0}},
                                  {"u1.z", 0.1, DegreesPerHour{-10.6}}}}};
  count(bench, {106, 0, -106}, 200);
  EXPECT_TRUE(bench.raised.empty()) << "y points to the east, where there is nothing to count";
  count(bench, {106, 0, 0}, 60);
  EXPECT_EQ(bench.raised, std::vector<std::string>{"gyro_dead u1.z"});
}

TEST(GyroDead, FindsIdenticalCountsOfNoisyAxisWithoutLatitude) {
  NoisyBench bench;
  bench.limits.units[0].axes[0].earth_rate.reset();
  std::mt19937 random(1);
  for (int i = 0; i < 600; ++i) count(bench, {100'000'000 + static_cast<std::int64_t>(random() % 1'000'000)}, 1);
  EXPECT_TRUE(bench.raised.empty());
  count(bench, {100'432'100}, 70);
  EXPECT_EQ(bench.raised, std::vector<std::string>{"gyro_dead gyro"});
}

TEST(GyroDead, FindsRateFarFromEarthRate) {
  const auto found = [](double deg_per_h, double band, bool is_turned,
                        std::optional<DegreesPerHour> largest_bias = std::nullopt) {
    NoisyBench bench;
    if (band > 0) bench.limits.gyro_band = DegreesPerHour{band};
    bench.limits.units[0].axes[0].largest_bias = largest_bias;
    bench.around.is_turned = is_turned;
    count(bench, {std::llround(deg_per_h * 10)}, 130);
    return bench.has(InterlockId::gyro_dead);
  };
  EXPECT_FALSE(found(10.6, 1000, false));
  EXPECT_FALSE(found(310, 1000, false)) << "a bias of 300 °/h";
  EXPECT_FALSE(found(900, 0, false)) << "any gyro without a stated bias";
  EXPECT_TRUE(found(1100, 0, false));
  EXPECT_TRUE(found(10.6 * 57.3, 0, false, DegreesPerHour{20})) << "degrees read as radians, good gyro";
  EXPECT_FALSE(found(200, 0, false, DegreesPerHour{20})) << "a bias ten times as large as it should be";
  EXPECT_FALSE(found(900, 0, false, DegreesPerHour{500})) << "a gyro of a class with such a bias";
  EXPECT_TRUE(found(-10.6, 0, false, DegreesPerHour{0})) << "the other way round";
  EXPECT_FALSE(found(900, 1000, false, DegreesPerHour{20})) << "the band of the rig file has priority";
  EXPECT_TRUE(found(206'265, 1000, false)) << "radians read as arcseconds";
  EXPECT_TRUE(found(10.6 * 57.3, 100, false)) << "degrees read as radians";
  EXPECT_TRUE(found(-10.6, 5, false)) << "the other way round";
  EXPECT_FALSE(found(-10.6, 5, true)) << "the unit is turned";
}

TEST(GyroDead, IgnoresUnitsThatAreOffDroppedOrMoved) {
  NoisyBench off, dropped, moved;
  off.around.gyro_is_off = true;
  dropped.around.dropped = {true};
  moved.around.units_are_moved = true;
  for (auto* bench : {&off, &dropped}) count(*bench, {0}, 300);
  count(moved, {500'000}, 300);
  for (auto* bench : {&off, &dropped, &moved}) EXPECT_TRUE(bench->raised.empty());
}

TEST(GyroDead, WarnsOfUnitWithoutWhichTheRunContinues) {
  NoisyBench bench;
  bench.limits.units = {{.name = "u1", .continue_when_silent = true, .axes = {{"u1", 0.1, DegreesPerHour{10.6}}}},
                        {.name = "u2", .continue_when_silent = true, .axes = {{"u2", 0.1, DegreesPerHour{10.6}}}}};
  bench.sample.units.assign(2, bench.sample.units.front());
  count(bench, {0}, 70);
  EXPECT_EQ(bench.raised, std::vector<std::string>{"gyro_dead u1"});
  EXPECT_EQ(bench.second().reaction, Reaction::warn);
  bench.sample.units[1].count.value = silence();
  EXPECT_GT(bench.seconds_until(Reaction::suspend, 300), 0) << "no unit counts";
}

/// Moves air and set point by 25 K; each thermometer follows by `share` of it. Returns the alarms.
std::vector<std::string> alarms_after_ramp(double share, int seconds) {
  InterlockBench bench;
  bench.limits.follow_band = {100};
  for (int i = 0; i < 300 + seconds; ++i) {
    const double way = std::min(25.0, i * 25.0 / 300);
    bench.around.sent = bench.chamber().air = bench.chamber().set_point = {20 + way};
    for (std::size_t t = 0; t < 9; ++t) bench.thermometer(t, 22 + share * way);
    bench.second();
  }
  return bench.raised;
}

TEST(NoThermalResponse, HoldsWhenAirMovedAndNoThermometerFollowed) {
  EXPECT_TRUE(alarms_after_ramp(0, 1600).empty()) << "a heavy unit has more time";
  EXPECT_EQ(alarms_after_ramp(0, 1900), std::vector<std::string>{"no_thermal_response "});
  EXPECT_TRUE(alarms_after_ramp(0.05, 4000).empty());
}

TEST(NoThermalResponse, HoldsWhenOnlySetPointMoved) {
  InterlockBench bench;
  bench.limits.policy[static_cast<std::size_t>(InterlockId::following)] = Reaction::warn;
  bench.seconds(10);
  bench.around.sent = bench.chamber().set_point = {45};
  EXPECT_NEAR(bench.seconds_until(Reaction::hold), 1800, 2);
}

TEST(NoThermalResponse, IgnoresSmallStepsAndSingleThermometerThatFollows) {
  InterlockBench small, one;
  for (auto* bench : {&small, &one}) bench->limits.follow_band = {100};
  small.around.sent = small.chamber().air = small.chamber().set_point = {20};
  small.seconds(10);
  small.around.sent = small.chamber().air = small.chamber().set_point = {39};
  small.seconds(4000);
  EXPECT_FALSE(small.has(InterlockId::no_thermal_response));
  for (int i = 0; i < 4000; ++i) {
    one.around.sent = one.chamber().air = one.chamber().set_point = {20 + std::min(40.0, 0.1 * i)};
    one.thermometer(8, 22 + std::min(35.0, 0.09 * i));
    one.second();
  }
  EXPECT_FALSE(one.has(InterlockId::no_thermal_response)) << "the others are in a heavy unit";
}

TEST(Drifting, NamesBothExchangedThermometers) {
  NoisyBench bench;
  bench.pass(100);
  std::swap(bench.sample.thermometers[0], bench.sample.thermometers[5]);
  InterlockBench still;
  still.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  still.thermometer(0, 24);
  still.seconds(10);
  still.thermometer(0, 22);
  still.thermometer(5, 24);
  still.seconds(31);
  EXPECT_EQ(still.raised, (std::vector<std::string>{"drifting A", "drifting F"}));
}

/// Returns the subjects that were reported as drifting.
std::vector<std::string> drifting_subjects(const InterlockBench& bench) {
  const std::string cause = "drifting ";
  std::vector<std::string> subjects;
  for (const auto& alarm : bench.raised)
    if (alarm.starts_with(cause)) subjects.push_back(alarm.substr(cause.size()));
  return subjects;
}

/// A runaway moves everything, faster than a healthy chamber can.
TEST(Drifting, IgnoresFastChangeOfEverything) {
  for (const double k_per_min : {20.0, 40.0, -40.0, 90.0, -75.0})
    for (const bool air_is_frozen : {false, true})
      for (const auto& of_air : {Quality{0.05, 0.01}, Quality{0.05, 0.1}, Quality{0, 0.5}}) {
        NoisyBench bench({0.02, 0.01}, of_air);
        bench.pass(60);
        bench.air_is_frozen = air_is_frozen;
        bench.pass(90, k_per_min / 60);
        bench.pass(60);
        EXPECT_EQ(drifting_subjects(bench), std::vector<std::string>()) << k_per_min << " " << air_is_frozen;
      }
}

/// The chamber shows a new value of its air only every third second, and the channels follow with different lags.
TEST(Drifting, IgnoresFastAirThatIsShownRarely) {
  InterlockBench bench;
  bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  std::vector<double> parts(9, 22);
  double air = 20;
  for (int t = 0; t < 240; ++t) {
    air += t > 60 && t < 150 ? 2.0 : 0;
    if (t % 3 == 0) bench.chamber().air = {air};
    for (std::size_t i = 0; i < parts.size(); ++i) {
      parts[i] += (air + 2 - parts[i]) / (3 + 4.0 * static_cast<double>(i));
      bench.thermometer(i, parts[i]);
    }
    bench.second();
  }
  EXPECT_EQ(drifting_subjects(bench), std::vector<std::string>());
}

TEST(Drifting, FindsJumpWhileEverythingMoves) {
  for (const double jump : {5.0, -5.0, 2.5, -3.0})
    for (const double k_per_min : {0.0, 3.0, 12.0, -12.0, 40.0, -40.0}) {
      NoisyBench bench;
      bench.pass(60);
      bench.pass(20, k_per_min / 60);
      bench.fourth_is_off_by = jump;
      bench.pass(60, k_per_min / 60);
      EXPECT_EQ(drifting_subjects(bench), std::vector<std::string>{"D"}) << jump << " " << k_per_min;
    }
}

/// A heavy part follows the air after a fast change; then its sensor jumps on the way.
TEST(Drifting, FindsJumpOfPartThatFollowsAir) {
  for (const double jump : {0.0, 4.0, -4.0}) {
    InterlockBench bench;
    bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
    double air = 20, part = 22;
    for (int t = 0; t < 200; ++t) {
      air += t >= 20 && t < 80 ? 0.7 : 0;
      part += (air + 2 - part) / 50;
      bench.chamber().air = {air};
      for (std::size_t i = 0; i < 9; ++i) bench.thermometer(i, air + 2);
      bench.thermometer(7, part + (t >= 100 ? jump : 0));
      bench.second();
    }
    const auto expected = jump == 0 ? std::vector<std::string>{} : std::vector<std::string>{"H"};
    EXPECT_EQ(drifting_subjects(bench), expected) << jump;
  }
}

TEST(Drifting, FindsJumpOfWholeInstrument) {
  for (const double k_per_min : {0.0, 5.0, -10.0}) {
    InterlockBench bench;
    bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
    for (int t = 0; t < 120; ++t) {
      const double moved = k_per_min / 60 * t;
      bench.around.sent = bench.chamber().air = bench.chamber().set_point = {20 + moved};
      for (std::size_t i = 0; i < 9; ++i) bench.thermometer(i, 22 + moved + (t >= 60 ? 4 : 0));
      bench.second();
    }
    EXPECT_EQ(drifting_subjects(bench).size(), 9u) << k_per_min;
  }
}

TEST(Drifting, FindsJumpAfterLostReadings) {
  InterlockBench bench;
  bench.limits.channels = {"A", "B", "C", "D", "E", "F", "G", "H", "shell"};
  bench.seconds(10);
  bench.sample.thermometers[4].value = silence();
  bench.seconds(4);
  bench.thermometer(4, 26);
  bench.seconds(40);
  EXPECT_EQ(drifting_subjects(bench), std::vector<std::string>{"E"});
}

TEST(Drifting, FindsThermometerThatDriftsAtRest) {
  NoisyBench bench;
  bench.pass(1300);
  const auto drift = [&](double kelvins_per_minute, int seconds) {
    for (int i = 0; i < seconds; ++i) bench.fourth_is_off_by += kelvins_per_minute / 60, bench.pass(1);
  };
  drift(0.8, 300);
  EXPECT_TRUE(bench.raised.empty()) << bench.raised.front();
  drift(2, 240);
  EXPECT_EQ(bench.raised, std::vector<std::string>{"drifting D"});
  drift(0, 120);
  EXPECT_EQ(bench.cleared, std::vector<std::string>{"drifting D"});
}

TEST(Drifting, IgnoresPartThatApproachesAir) {
  for (const double minutes : {8.0, 15.0, 30.0, 50.0, 90.0, 240.0}) {
    NoisyBench bench;
    for (int t = 0; t < 4 * 3600; ++t) {
      bench.fourth_is_off_by = -90 * std::exp(-t / (60 * minutes));
      bench.pass(1);
    }
    EXPECT_EQ(std::ranges::count(bench.raised, "drifting D"), 0) << minutes;
  }
}

/// A slow ramp moves the set point by less than its resolution per second.
TEST(Drifting, IgnoresPartThatLagsBehindSlowRamp) {
  for (const double k_per_min : {-1.15, 1.07, 1.1}) {
    NoisyBench bench;
    bench.pass(1300);
    for (int t = 0; t < 3000; ++t) {
      bench.fourth_is_off_by -= k_per_min / 60;
      bench.pass(1, k_per_min / 60);
    }
    EXPECT_EQ(std::ranges::count(bench.raised, "drifting D"), 0) << k_per_min;
  }
}

TEST(Drifting, FindsPartThatBecomesLooseDuringHold) {
  NoisyBench bench;
  for (int t = 0; t < 3600; ++t) {
    bench.fourth_is_off_by = -60 * std::exp(-t / 3600.0);
    bench.pass(1);
  }
  const double from = bench.fourth_is_off_by;
  for (int t = 0; t < 240; ++t) {
    bench.fourth_is_off_by = from * std::exp(-t / 120.0);
    bench.pass(1);
  }
  EXPECT_EQ(std::ranges::count(bench.raised, "drifting D"), 1);
}

TEST(Drifting, FindsDriftThatBeganBeforeHold) {
  NoisyBench bench;
  for (int t = 0; t < 3600; ++t) {
    bench.fourth_is_off_by += 2.0 / 60;
    bench.pass(1);
  }
  EXPECT_EQ(std::ranges::count(bench.raised, "drifting D"), 1);
}

TEST(Drifting, IgnoresSpikesRampsAndThermometersThatFollowAir) {
  NoisyBench bench;
  bench.pass(100);
  bench.thermometer(2, 60);
  bench.second();
  bench.pass(600, 0.1);
  bench.pass(600, -0.1);
  EXPECT_TRUE(bench.raised.empty());
}

}  // namespace
}  // namespace gyrotherm::run
