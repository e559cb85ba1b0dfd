// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "core/random.hpp"
#include "simulator/gyro_bias.hpp"

namespace gyrotherm::simulator {
namespace {

RandomStream drawn_by(std::uint64_t seed) { return {seed, RandomPurpose::bias_spread}; }

TEST(Play, LagsByHalfWidthAfterTurn) {
  Play play(3, 20);
  play.follow(40);
  EXPECT_DOUBLE_EQ(play.lag_k(), 3);
  play.follow(38);
  EXPECT_DOUBLE_EQ(play.lag_k(), 1);
  play.follow(10);
  EXPECT_DOUBLE_EQ(play.lag_k(), -3);
}

TEST(Play, DoesNotMoveWithinHalfWidth) {
  Play play(3, 20);
  for (const double input : {22.9, 17.1, 21.0, 20.0}) {
    play.follow(input);
    EXPECT_DOUBLE_EQ(play.lag_k(), input - 20);
  }
}

/// A closed cycle of amplitude a encloses a parallelogram with a width of 2r and a height of 2(a − r).
TEST(Play, EnclosesKnownAreaInCycle) {
  constexpr double kHalfWidth = 5;
  constexpr double kAmplitude = 40;
  constexpr int kSteps = 100000;
  Play play(kHalfWidth, 0);
  const auto input = [](int i) { return kAmplitude * std::sin(2 * std::numbers::pi * i / kSteps); };
  for (int i = 0; i < kSteps; ++i) play.follow(input(i));
  double area = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double before = play.lag_k();
    play.follow(input(i + 1));
    area += (before + play.lag_k()) / 2 * (input(i + 1) - input(i));
  }
  EXPECT_NEAR(area, 4 * kHalfWidth * (kAmplitude - kHalfWidth), 1e-3);
}

TEST(Play, RemembersOnlyTurningPoints) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    auto random = drawn_by(seed);
    Play direct(4, 0);
    Play by_way_of(4, 0);
    double at = 0;
    for (int turn = 0; turn < 30; ++turn) {
      const double next = 20 * random.normal();
      direct.follow(next);
      for (int i = 1; i <= 7; ++i) by_way_of.follow(at + (next - at) * i / 7);
      at = next;
      ASSERT_NEAR(direct.lag_k(), by_way_of.lag_k(), 1e-12) << "seed " << seed;
      ASSERT_LE(std::abs(direct.lag_k()), 4 + 1e-12) << "seed " << seed;
    }
  }
}

/// An excursion within the last turning points that returns to its start has no lasting effect.
TEST(Play, ForgetsInnerExcursion) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    auto random = drawn_by(seed);
    Play once(4, 0);
    once.follow(50);
    once.follow(-10);
    Play twice = once;
    for (int i = 0; i < 10; ++i) twice.follow(-10 + 60 * random.uniform());
    twice.follow(-10);
    once.follow(-60);
    twice.follow(-60);
    ASSERT_DOUBLE_EQ(once.lag_k(), twice.lag_k()) << "seed " << seed;
  }
}

TEST(ModeLock, KeepsModeWithinRangeOfActuator) {
  ModeLock lock({.kelvin_per_mode = 50, .reach_modes = 1.5, .step_deg_per_h = 1}, 20);
  for (const double path_c : {20.0, 94.0, -54.0}) {
    lock.follow(path_c);
    EXPECT_EQ(lock.mode(), 0) << path_c;
  }
}

TEST(ModeLock, HopsToNearestModeOutsideRangeAndReturnsLater) {
  ModeLock lock({.kelvin_per_mode = 50, .reach_modes = 1.5, .step_deg_per_h = 1}, 20);
  lock.follow(96);
  EXPECT_EQ(lock.mode(), 2);
  lock.follow(60);
  EXPECT_EQ(lock.mode(), 2) << "the return has another threshold";
  lock.follow(44);
  EXPECT_EQ(lock.mode(), 0);
}

TEST(ModeLock, ContinuesFromPresentBiasIfHopInterruptsHop) {
  ModeLock lock({.kelvin_per_mode = 10, .reach_modes = 0.6, .step_deg_per_h = 1, .shortest_s = 10, .longest_s = 10},
                20);
  lock.follow(30);
  for (int second = 0; second < 4; ++second) lock.follow(30);
  EXPECT_NEAR(lock.deg_per_h(), 0.4, 1e-12);
  lock.follow(20);
  EXPECT_EQ(lock.mode(), 0);
  EXPECT_NEAR(lock.deg_per_h(), 0.5, 1e-12) << "the second that passed belongs to the first hop";
  for (int second = 0; second < 5; ++second) lock.follow(20);
  EXPECT_NEAR(lock.deg_per_h(), 0.25, 1e-12);
  for (int second = 0; second < 5; ++second) lock.follow(20);
  EXPECT_EQ(lock.deg_per_h(), 0);
}

TEST(ModeLock, IsOffWithoutPeriod) {
  ModeLock lock({}, 20);
  lock.follow(1000);
  EXPECT_EQ(lock.mode(), 0);
}

}  // namespace
}  // namespace gyrotherm::simulator
