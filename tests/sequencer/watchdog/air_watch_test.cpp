// SPDX-License-Identifier: Apache-2.0
/// Judges the movement of the air in a chamber that is being made safe.
#include "sequencer/watchdog/air_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace gyrotherm::watchdog {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;
constexpr Celsius kSafe{22};

/// Returns the verdict after `length` of readings, one a second.
AirVerdict after(Duration length, AirSource source, const std::function<double(double s)>& air_at,
                 Duration observe = minutes(5)) {
  AirWatch watch(kSafe, observe);
  watch.begin(source);
  AirVerdict verdict{};
  for (Duration at{}; at <= length; at += kSecond) {
    verdict = watch.add_reading({air_at(to_seconds(at))}, at);
    if (verdict == AirVerdict::moves_away || verdict == AirVerdict::does_not_move) return verdict;
  }
  return verdict;
}

constexpr auto kController = AirSource::controller;

TEST(AirWatch, AcceptsAirThatArrivesOrApproaches) {
  const auto cools = [](double s) { return 22 + 40 * std::exp(-s / 600); };
  EXPECT_EQ(after(minutes(5) - kSecond, kController, cools), AirVerdict::watching) << "too early";
  EXPECT_EQ(after(minutes(5), kController, cools), AirVerdict::shown);
  EXPECT_EQ(after(minutes(5), kController, [](double s) { return 22 + 0.3 * std::sin(s); }), AirVerdict::shown);
  EXPECT_EQ(after(minutes(5), kController, [](double s) { return -50 + s / 60; }), AirVerdict::shown) << "warms up";
  EXPECT_EQ(after(minutes(5), kController, [](double s) { return s < 30 ? 60 + s / 15 : 62.4 - s / 30; }),
            AirVerdict::shown)
      << "turns round";
}

TEST(AirWatch, DetectsAirThatMovesAway) {
  EXPECT_EQ(after(minutes(1), kController, [](double s) { return 40 + 0.5 * s; }), AirVerdict::moves_away);
  EXPECT_EQ(after(minutes(1), kController, [](double s) { return -20 - 0.5 * s; }), AirVerdict::moves_away);
  EXPECT_EQ(after(minutes(1), kController, [](double s) { return 22 + 0.5 * s; }), AirVerdict::moves_away);
  EXPECT_EQ(after(minutes(5), kController, [](double s) { return std::abs(60 - s) + 22; }), AirVerdict::moves_away)
      << "passes the set point and continues";
}

TEST(AirWatch, ExtendsWatchOfSlowAirAndEndsItWhenAirIsStable) {
  const auto slow = [](double s) { return 60 - s / 500; };
  EXPECT_EQ(after(minutes(8), kController, slow), AirVerdict::watching);
  EXPECT_EQ(after(minutes(9), kController, slow), AirVerdict::shown);
  EXPECT_EQ(after(minutes(14), kController, [](double) { return 60.0; }), AirVerdict::watching);
  EXPECT_EQ(after(minutes(16), kController, [](double) { return 60.0; }), AirVerdict::does_not_move);
}

TEST(AirWatch, IgnoresSingleOutlier) {
  const auto with_spike = [](double spike) { return [=](double s) { return s == 100 ? spike : 22.0; }; };
  for (const double spike : {22 + 40.0, 22 - 40.0})
    EXPECT_EQ(after(minutes(5), kController, with_spike(spike)), AirVerdict::shown);
  EXPECT_EQ(after(minutes(6), kController, [](double s) { return s == 100 ? 70 : 60; }), AirVerdict::watching)
      << "the return from a spike is not a movement";
}

TEST(AirWatch, AllowsDriftToAmbientWhenChamberIsOff) {
  EXPECT_EQ(after(minutes(5), AirSource::seen_off, [](double s) { return 22 + s / 60; }), AirVerdict::shown);
  EXPECT_EQ(after(minutes(5), AirSource::seen_off, [](double) { return 60.0; }), AirVerdict::shown) << "does not rise";
  EXPECT_EQ(after(minutes(5), AirSource::switched_off, [](double) { return 60.0; }), AirVerdict::watching)
      << "nothing shows that the chamber is off";
  EXPECT_EQ(after(minutes(5), AirSource::seen_off, [](double s) { return 40 + s / 10; }), AirVerdict::moves_away);
  EXPECT_EQ(after(minutes(5), AirSource::seen_off, [](double s) { return -s / 10; }), AirVerdict::moves_away);
}

TEST(AirWatch, WatchesQuickDriftOfChamberThatIsOffUntilItSlowsOrGoesTooFar) {
  for (const auto source : {AirSource::seen_off, AirSource::switched_off}) {
    const auto heats = [](double s) { return 16 + s / 20; };
    EXPECT_EQ(after(minutes(5), source, heats), AirVerdict::watching) << "3 K/min through room temperature";
    EXPECT_EQ(after(minutes(20), source, heats), AirVerdict::moves_away);
    const auto slows = [](double s) { return 34 - 14 * std::exp(-s / 300); };
    EXPECT_EQ(after(minutes(4), source, slows, minutes(3)), AirVerdict::watching);
    EXPECT_EQ(after(minutes(15), source, slows), AirVerdict::shown) << "ambient temperature";
  }
  EXPECT_EQ(after(minutes(5), AirSource::seen_off, [](double s) { return -10 + s / 20; }), AirVerdict::shown)
      << "towards the set point";
}

TEST(AirWatch, ReportsDriftOnlyAfterTimeToObserve) {
  AirWatch watch(kSafe, minutes(2));
  watch.begin(AirSource::seen_off);
  for (int s = 0; s <= 180; ++s) {
    (void)watch.add_reading({22 + s / 20.0}, kSecond * s);
    EXPECT_EQ(watch.is_drifting(), s >= 120) << s;
  }
}

TEST(AirWatch, CountsOnlyTimeWithReadings) {
  AirWatch watch(kSafe, minutes(5));
  EXPECT_EQ(watch.add_reading({22}, {}), AirVerdict::watching);
  EXPECT_EQ(watch.add_reading({22}, minutes(60)), AirVerdict::watching) << "it was silent for an hour";
  EXPECT_EQ(watch.watched(), seconds(30));
}

TEST(AirWatch, AcceptsFirstReadingAndReportsItWithoutWatchTime) {
  AirWatch watch(kSafe, {});
  EXPECT_EQ(watch.add_reading({60}, {}), AirVerdict::shown);
  EXPECT_EQ(watch.describe(), "air 60.00 °C, not watched");
}

}  // namespace
}  // namespace gyrotherm::watchdog
