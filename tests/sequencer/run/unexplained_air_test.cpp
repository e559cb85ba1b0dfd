// SPDX-License-Identifier: Apache-2.0
/// Chambers whose set points have a wrong scale, which no read-back reveals: the air moves away from the set point.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "tests/sequencer/run/interlock_bench.hpp"
#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

using interlocks::InterlockId;
using interlocks::Reaction;

std::string hold(const std::string& at, const std::string& time) {
  return "[[segment]]\nkind = \"hold\"\nat = " + at + "\ntime = \"" + time + "\"\n";
}

/// Makes the chamber heat at 6 to 7 K/min, because 22 °C is 220 °C for it.
void make_wrong_scale(tests::Bench& bench) {
  bench.chamber().air_c = bench.chamber().set_point_c = 22;
  bench.chamber().scale = 10;
  bench.chamber().lag_s = 1800;
}

TEST(WrongSetPointScale, SuspendsWithinMinuteAndAbortsWithinTwo) {
  tests::Bench bench(hold("22", "2 h"));
  make_wrong_scale(bench);
  const int suspended = bench.until(RunState::suspended, 200);
  EXPECT_GT(suspended, 20);
  EXPECT_LE(suspended, 60);
  EXPECT_LE(suspended + bench.until(RunState::aborting, 200), 120);
  EXPECT_LT(bench.chamber().air_c, 32);
  EXPECT_TRUE(bench.told(EventKind::interlock, "the air moves away from the set point"));
  EXPECT_TRUE(bench.told(EventKind::interlock, "check scale and unit of the set point"));
}

TEST(WrongSetPointScale, IsFoundInRampThatIsSlowerThanChamber) {
  tests::Bench bench(hold("22", "30 s") + "[[segment]]\nkind = \"ramp\"\nto = 27\nrate = \"4 °C/min\"\n");
  make_wrong_scale(bench);
  EXPECT_GT(bench.until(RunState::aborting, 165), 0) << "the same run ended as complete";
}

TEST(WrongSetPointScale, ShortRunIsNotComplete) {
  tests::Bench bench(hold("22", "18 s"));
  make_wrong_scale(bench);
  EXPECT_EQ(bench.seconds(2000), RunOutcome::made_safe);
  EXPECT_EQ(bench.count(EventKind::interlock, "following (abort): the air moves away from the set point"), 1);
  EXPECT_EQ(bench.count(EventKind::finished, "complete"), 0);
  EXPECT_EQ(bench.record().alarms().unacknowledged().size(), 1u);
}

TEST(WrongSetPointScale, StopDoesNotLeaveChamberAtItsSetPoint) {
  tests::Bench bench(hold("22", "2 h"), [](rig::RigFile& file) { file.run_limits.on_stop = interlocks::OnStop::hold; });
  make_wrong_scale(bench);
  bench.seconds(18);
  bench.run_controller().submit(OperatorCommand::stop, "Ada");
  bench.seconds(1);
  EXPECT_EQ(bench.run_controller().run_state(), RunState::aborting);
  EXPECT_EQ(bench.seconds(2000), RunOutcome::made_safe) << "not stopped";
}

TEST(WrongSetPointScale, StopLeavesChamberThatFollows) {
  tests::Bench bench(hold("22", "2 h"), [](rig::RigFile& file) { file.run_limits.on_stop = interlocks::OnStop::hold; });
  bench.chamber().air_c = bench.chamber().set_point_c = 22;
  bench.seconds(18);
  bench.run_controller().submit(OperatorCommand::stop, "Ada");
  EXPECT_EQ(bench.seconds(1), RunOutcome::stopped);
  EXPECT_TRUE(bench.instruments().switched.empty());
}

TEST(EndOfRun, WaitsUntilAirHasBeenObserved) {
  for (const int observe : {0, 5, 40, 300}) {
    tests::Bench bench(hold("22", "10 s"), [&](rig::RigFile& file) {
      file.simulated = false;
      file.safe_observe = std::chrono::seconds(observe);
    });
    bench.chamber().air_c = bench.chamber().set_point_c = 22;
    int lasted = 0;
    while (bench.seconds(1) == RunOutcome::going_on && lasted < 400) ++lasted;
    EXPECT_EQ(bench.run_controller().run_state(), RunState::complete);
    EXPECT_NEAR(lasted, std::max(10, std::min(observe, 60)), 2) << observe;
    EXPECT_EQ(bench.count(EventKind::note, "the profile's last second continues"), observe > 10 ? 1 : 0);
  }
}

TEST(EndOfRun, IsCompleteWhileAirStillApproaches) {
  tests::Bench bench(
      "[[segment]]\nkind = \"hold\"\nat = 22\ntime = \"5 min\"\n[[segment]]\nkind = \"ramp\"\n"
      "to = 52\nrate = \"6 °C/min\"\n");
  bench.chamber().air_c = bench.chamber().set_point_c = 22;
  bench.chamber().lag_s = 1200;
  EXPECT_EQ(bench.seconds(2000), RunOutcome::complete) << "far behind, but on its way";
}

TEST(EndOfRun, IsRefusedWhileAirStaysAwayFromSetPoint) {
  for (const double rise_per_min : {0.0, -0.5, 0.3}) {
    InterlockBench bench;
    bench.chamber().activity = ChamberActivity::running;
    bench.chamber().air = {35};
    bench.chamber().set_point = {35};
    bench.seconds(120);
    EXPECT_EQ(leaving_refusal(bench.limits, bench.memory, bench.sample), "");
    bench.chamber().set_point = {45};
    for (int s = 0; s < 900; ++s) {
      bench.chamber().air = {35 + rise_per_min * s / 60};
      bench.second();
    }
    const auto why = leaving_refusal(bench.limits, bench.memory, bench.sample);
    EXPECT_EQ(why.empty(), rise_per_min > 0) << why;
    bench.sample.chamber.value = failure(FaultKind::timeout, "chamber", "no reply in 500 ms");
    EXPECT_EQ(leaving_refusal(bench.limits, bench.memory, bench.sample), "") << "silence has its own interlock";
  }
}

/// A short ramp: the lag of the chamber is still a large part of the way, and the run ends before "following" acts.
TEST(EndOfRun, IsRefusedAfterShortRampWithoutEffect) {
  for (const double rise_per_min : {0.0, -1.0, 2.0})
    for (const int ramp_s : {60, 120, 200}) {
      InterlockBench bench;
      bench.chamber().activity = ChamberActivity::running;
      bench.chamber().air = bench.chamber().set_point = {20};
      bench.seconds(70);
      for (int s = 1; s <= ramp_s; ++s) {
        bench.around.sent = bench.chamber().set_point = {20 + 5.0 * s / 60};
        bench.chamber().air = {20 + rise_per_min * s / 60};
        bench.second();
      }
      const auto why = leaving_refusal(bench.limits, bench.memory, bench.sample);
      const bool is_within_band = ramp_s == 60 && rise_per_min >= 0;
      EXPECT_EQ(why.empty(), rise_per_min > 0 || is_within_band) << rise_per_min << ", " << ramp_s << " s: " << why;
    }
}

TEST(EndOfRun, IsRefusedWhileChamberIsSilent) {
  InterlockBench bench;
  bench.seconds(60);
  bench.sample.chamber.value = failure(FaultKind::timeout, "chamber", "no reply in 500 ms");
  bench.second();
  EXPECT_EQ(leaving_refusal(bench.limits, bench.memory, bench.sample), "") << "one lost answer";
  bench.seconds(2);
  EXPECT_EQ(leaving_refusal(bench.limits, bench.memory, bench.sample),
            "the chamber has given no valid reading for 3 s, so its set point is not confirmed");
}

TEST(EndOfRun, IsRefusedWhileChamberIsRestartedOrRefusesSetPoints) {
  const auto refusal_after = [](const std::function<void(InterlockBench&)>& change) {
    InterlockBench bench;
    bench.chamber().activity = ChamberActivity::running;
    bench.seconds(60);
    change(bench);
    bench.seconds(3);
    return leaving_refusal(bench.limits, bench.memory, bench.sample);
  };
  EXPECT_EQ(refusal_after([](InterlockBench&) {}), "");
  EXPECT_NE(refusal_after([](InterlockBench& b) { b.around.refusals = 10; }), "") << "refuses set points";
  for (const auto activity : {ChamberActivity::running, ChamberActivity::off})
    EXPECT_NE(refusal_after([&](InterlockBench& b) {
                const ChamberState restarted{.air = {20}, .set_point = {50}, .activity = activity};
                b.sample.chamber.value = failure(FaultKind::timeout, "chamber", "no reply in 500 ms");
                b.second();
                b.sample.chamber.value = restarted;
              }),
              "")
        << name(activity);
}

/// While a chamber keeps a foreign set point, an earlier foreign one explains no air.
TEST(Following, IsWatchedAtSecondForeignSetPoint) {
  InterlockBench bench;
  bench.chamber() = {.air = {20}, .set_point = {20}, .activity = ChamberActivity::running};
  bench.seconds(2400);
  bench.chamber().set_point = {60};
  bench.second();
  bench.chamber().set_point = {22};
  int lasted = 0;
  for (; lasted < 3000 && !bench.has(InterlockId::following); ++lasted) {
    bench.chamber().air = {20 + 2.0 * lasted / 60};
    bench.second();
  }
  EXPECT_LT(bench.chamber().air, Celsius{45}) << lasted;
}

/// A set point of another program, seen for a second, must not widen the band in which the air counts as following.
TEST(Following, IsWatchedAgainAfterForeignSetPoint) {
  const auto seconds_until_alarm = [](double foreign) {
    InterlockBench bench;
    bench.chamber() = {.air = {20}, .set_point = {20}, .activity = ChamberActivity::running};
    bench.seconds(2400);
    bench.chamber().set_point = {foreign};
    bench.second();
    bench.chamber().set_point = {20};
    bench.seconds(10);
    int lasted = 0;
    for (; lasted < 3000 && !bench.has(InterlockId::following); ++lasted) {
      bench.chamber().air = {20 + 0.5 * lasted / 60};
      bench.second();
    }
    return lasted;
  };
  const int undisturbed = seconds_until_alarm(20);
  EXPECT_LT(undisturbed, 3000);
  for (const double foreign : {60.0, -50.0, 23.0}) EXPECT_NEAR(seconds_until_alarm(foreign), undisturbed, 5) << foreign;
}

/// Evaluates the interlocks with an air temperature that a function of time returns. Returns the most severe reaction.
Reaction most_severe(const std::function<double(double)>& air, const std::function<double(double)>& set_point,
                     int time_s) {
  InterlockBench bench;
  auto most = Reaction::go_on;
  for (int s = 0; s < time_s; ++s) {
    bench.chamber().air = {air(s)};
    bench.chamber().set_point = {set_point(s)};
    bench.chamber().activity = ChamberActivity::running;
    bench.around.sent = bench.chamber().set_point;
    for (std::size_t i = 0; i < bench.sample.thermometers.size(); ++i) bench.thermometer(i, air(s));
    most = std::max(most, bench.second().reaction);
  }
  return most;
}

TEST(UnexplainedAir, AcceptsDisturbancesOfRealChambers) {
  const auto at_20 = [](double) { return 20.0; };
  const auto compressor = [](double s) { return 20 - 5 * std::exp(-(s - 30) * (s - 30) / 50); };
  EXPECT_EQ(most_severe(compressor, at_20, 600), Reaction::go_on) << "5 K below for some seconds";
  const auto swings = [](double s) { return 20 + 2.8 * std::sin(s / 40); };
  EXPECT_LT(most_severe(swings, at_20, 280), Reaction::suspend);
  const auto ramp = [](double s) { return 20 - std::min(s * 5 / 60, 40.0); };
  const auto lags = [&](double s) { return ramp(std::max(0.0, s - 120)) + (s > 600 ? -2.0 : 0.0); };
  EXPECT_LT(most_severe(lags, ramp, 900), Reaction::suspend) << "overshoots by 2 K";
}

TEST(UnexplainedAir, ActsInEitherDirection) {
  const auto at_20 = [](double) { return 20.0; };
  for (const double rate : {-0.1, 0.1}) {
    const auto moves = [&](double s) { return 20 + rate * s; };
    EXPECT_LT(most_severe(moves, at_20, 45), Reaction::suspend);
    EXPECT_EQ(most_severe(moves, at_20, 60), Reaction::suspend);
    EXPECT_EQ(most_severe(moves, at_20, 120), Reaction::abort);
  }
}

TEST(UnexplainedAir, DoorWithoutSwitchOnlySuspends) {
  const auto at_80 = [](double) { return 80.0; };
  EXPECT_EQ(most_severe([](double s) { return 22 + 58 * std::exp(-s / 60); }, at_80, 280), Reaction::suspend);
  EXPECT_EQ(most_severe([](double s) { return 80 + 0.1 * s; }, at_80, 120), Reaction::abort) << "away from the room";
}

TEST(UnexplainedAir, JumpOfSensorIsLeftToItsInterlock) {
  const auto at_20 = [](double) { return 20.0; };
  EXPECT_LT(most_severe([](double s) { return s < 50 ? 20.0 : 28.0; }, at_20, 280), Reaction::suspend);
}

TEST(UnexplainedAir, IsNotJudgedAfterHalfAnHour) {
  const auto at_20 = [](double) { return 20.0; };
  const auto leaves = [](double from) {
    return [from](double s) { return 20 + std::clamp((s - from) / 10, 0.0, 9.0); };
  };
  EXPECT_EQ(most_severe(leaves(1500), at_20, 1620), Reaction::abort);
  EXPECT_LT(most_severe(leaves(1900), at_20, 2020), Reaction::suspend);
}

TEST(UnexplainedAir, IsNotJudgedOnceAirHasFollowed) {
  const auto set_point = [](double s) { return s < 10 ? 20.0 : 35.0; };
  const auto follows_then_leaves = [](double s) {
    return s < 600 ? 35 - 15 * std::exp(-std::max(0.0, s - 10) / 120) : 35 + std::min((s - 600) * 0.1, 10.0);
  };
  EXPECT_EQ(most_severe(follows_then_leaves, set_point, 800), Reaction::go_on) << "follow_time applies";
  EXPECT_EQ(most_severe(follows_then_leaves, set_point, 1100), Reaction::suspend);
}

TEST(UnexplainedAir, IgnoresStatesWithoutConditioning) {
  for (const auto activity : {ChamberActivity::off, ChamberActivity::door_open, ChamberActivity::not_following}) {
    InterlockBench bench;
    bench.chamber().activity = activity;
    for (int s = 0; s < 100; ++s) {
      bench.chamber().air = {20 + 0.1 * s};
      bench.second();
    }
    EXPECT_FALSE(bench.has(InterlockId::following)) << static_cast<int>(activity);
  }
}

TEST(UnexplainedAir, IgnoresUnreadableSetPoint) {
  InterlockBench bench;
  bench.chamber().set_point = {std::nan("")};
  for (int s = 0; s < 100; ++s) {
    bench.chamber().air = {20 + 0.1 * s};
    bench.second();
  }
  EXPECT_FALSE(bench.has(InterlockId::following));
}

}  // namespace
}  // namespace gyrotherm::run
