// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/repeat_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace gyrotherm::exchange {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kWatchedRows = 8000;
constexpr double kStep_s = 5;

/// A chamber with four ramps and rests, as seen by a thermometer with a lag.
class Thermometer {
 public:
  Thermometer(double lag_s, double noise_k, double resolution_k, std::uint64_t seed = 1)
      : lag_s_(lag_s), noise_k_(noise_k), resolution_k_(resolution_k), random_(seed) {}
  double next() {
    const double phase = std::fmod(row_++ * kStep_s / 10'000, 1.0);
    const double chamber_c = phase < 0.25   ? 20
                             : phase < 0.5  ? 20 + 160 * (phase - 0.25)
                             : phase < 0.75 ? 60
                                            : 60 - 160 * (phase - 0.75);
    if (std::isnan(body_c_)) body_c_ = chamber_c;
    body_c_ += (1 - std::exp(-kStep_s / lag_s_)) * (chamber_c - body_c_);
    const double reading = body_c_ + noise_k_ * normal_(random_);
    return resolution_k_ > 0 ? resolution_k_ * std::round(reading / resolution_k_) : reading;
  }

 private:
  double lag_s_, noise_k_, resolution_k_, body_c_ = kNan;
  int row_ = 0;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_{};
};

using Change = std::function<void(int row, std::vector<double>& values)>;

/// Watches a reference thermometer, a second thermometer and a gyro.
Notes watch(Thermometer second, const Change& change = {}, double gyro_resolution = 1e-4, int rows = kWatchedRows) {
  RepeatWatch watch;
  watch.add({.name = "T1", .unit = "°C", .is_temperature = true, .has_missing_texts = true});
  watch.add({.name = "T2", .unit = "°C", .is_temperature = true, .has_missing_texts = true});
  watch.add({.name = "gyro", .unit = "°/h", .is_axis = true, .has_missing_texts = true});
  Thermometer first(300, 0.02, 0.01, 2);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(5, 0.3);
  for (int row = 0; row < rows; ++row) {
    std::vector<double> values{first.next(), second.next(),
                               gyro_resolution * std::round(normal(random) / gyro_resolution)};
    if (change) change(row, values);
    watch.push(from_seconds(row * kStep_s), values);
  }
  return watch.warnings();
}

Thermometer fine() { return {600, 0.02, 0.01}; }
Thermometer coarse() { return {600, 0, 0.1}; }

/// Replaces the values of a channel from `first` to `last` by a value, or by its own first value.
Change hold(std::size_t channel, int first, int last, double value = kNan) {
  return [=, held = kNan](int row, std::vector<double>& values) mutable {
    if (row < first || row > last) return;
    if (row == first) held = std::isnan(value) ? values[channel] : value;
    values[channel] = held;
  };
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(RepeatWatch, AcceptsGoodChannels) {
  EXPECT_EQ(watch(fine()), Notes{});
  EXPECT_EQ(watch(coarse()), Notes{}) << "rests of 2500 s have one value";
  EXPECT_EQ(watch({600, 0, 0}), Notes{}) << "no noise and no resolution";
  EXPECT_EQ(watch({600, 0.05, 0.1}), Notes{});
  EXPECT_EQ(watch({600, 0.01, 0.1}), Notes{});
  EXPECT_EQ(watch({600, 0.02, 1}), Notes{});
  EXPECT_EQ(watch({40'000, 0, 0.5}), Notes{}) << "a heavy body that hardly follows";
  EXPECT_EQ(watch({1e9, 0, 0.1}), Notes{}) << "a thermometer outside the chamber";
  EXPECT_EQ(watch({1e9, 0.01, 0.1}), Notes{});
  EXPECT_EQ(watch(fine(), {}, 1), Notes{}) << "a gyro with few counts";
  EXPECT_EQ(watch(fine(), {}, 10), Notes{}) << "a gyro without a count";
}

TEST(RepeatWatch, AcceptsSensorsThatLoggersSampleSlowly) {
  for (const int period : {10, 60, 200}) {
    const auto notes = watch(fine(), [held = kNan, period](int row, std::vector<double>& values) mutable {
      if (row % period == 0) held = values[1];
      values[1] = held;
    });
    EXPECT_EQ(notes, Notes{}) << period;
  }
}

TEST(RepeatWatch, ReportsFrozenThermometer) {
  for (const auto& sensor : {fine(), Thermometer(600, 0, 0), coarse(), Thermometer(600, 0.05, 0.5)}) {
    const auto notes = watch(sensor, hold(1, kWatchedRows / 2 + 700, kWatchedRows - 1));
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_TRUE(contains(notes[0], "T2 repeats ")) << notes[0];
    EXPECT_TRUE(contains(notes[0], "while T1 moves from ")) << notes[0];
    EXPECT_TRUE(contains(notes[0], " to row 8000 (11 h 06 min 35 s)")) << notes[0];
    EXPECT_TRUE(contains(notes[0], "remove T2 from the map")) << notes[0];
  }
}

TEST(RepeatWatch, NamesRowsTimesAndValue) {
  const auto notes = watch(fine(), hold(1, 4000, 4999, 29.87));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(contains(notes[0],
                       "T2 repeats 29.87 °C in 1000 consecutive values, from row 4001 (5 h 33 min 20 s) to row "
                       "5000 (6 h 56 min 35 s)"))
      << notes[0];
}

TEST(RepeatWatch, ReportsFrozenSensorAtStartInMiddleAndTwice) {
  EXPECT_EQ(watch(fine(), hold(1, 0, 1500)).size(), 1u);
  EXPECT_EQ(watch(fine(), hold(1, 1500, 1560)).size(), 1u) << "61 values while the noise is twice the resolution";
  EXPECT_EQ(watch(fine(),
                  [one = hold(1, 1000, 1500), two = hold(1, 5000, 5600)](int row, auto& values) {
                    one(row, values);
                    two(row, values);
                  })
                .size(),
            2u);
}

TEST(RepeatWatch, ReportsFrozenGyro) {
  const auto notes = watch(fine(), hold(2, 1000, 1999));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(contains(notes[0], "gyro repeats ")) << notes[0];
  EXPECT_FALSE(contains(notes[0], "remove")) << notes[0];
}

TEST(RepeatWatch, ReportsErrorValuesAfterJumps) {
  for (const double code : {0.0, -127.0, 850.0, 25.0})
    for (const auto& sensor : {fine(), coarse()}) {
      const auto notes = watch(sensor, hold(1, 1900, 3000, code));
      ASSERT_EQ(notes.size(), 1u) << code;
      EXPECT_TRUE(contains(notes[0], "after a jump from")) << notes[0];
      EXPECT_TRUE(contains(notes[0], "missing = [\"")) << notes[0];
    }
  const auto at_start = watch(fine(), hold(1, 0, 400, -40));
  ASSERT_EQ(at_start.size(), 1u);
  EXPECT_TRUE(contains(at_start[0], "until a jump to")) << at_start[0];
}

TEST(RepeatWatch, NamesNumberOfFileInRemedy) {
  RepeatWatch watch;
  watch.add({.name = "die",
             .unit = "°C",
             .is_temperature = true,
             .scale = 0.5,
             .offset = -273.15,
             .has_missing_texts = true});
  Thermometer sensor = fine();
  for (int row = 0; row < kWatchedRows; ++row) {
    const double value = row < 4100 ? sensor.next() : 0.5 * 65535 / 100 - 273.15;
    watch.push(from_seconds(row), std::vector{value});
  }
  const auto notes = watch.warnings();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(contains(notes[0], "missing = [\"655.35\"]")) << notes[0];
}

TEST(RepeatWatch, IgnoresMissingValuesWithinRepetition) {
  const auto notes = watch(fine(), [frozen = hold(1, 4000, 7000)](int row, std::vector<double>& values) {
    frozen(row, values);
    if (row % 3 == 0) values[1] = kNan;
  });
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(contains(notes[0], "in 2001 consecutive values")) << notes[0];
  EXPECT_EQ(watch(fine(), hold(1, 0, -1), 1e-4, 0), Notes{}) << "no row";
  EXPECT_EQ(watch(fine(), [](int, std::vector<double>& values) { values[1] = kNan; }), Notes{});
}

TEST(RepeatWatch, ReportsLastingJump) {
  const auto notes = watch(fine(), [](int row, std::vector<double>& values) { values[1] += row >= 6000 ? 18 : 0; });
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(contains(notes[0], "T2 jumps from ")) << notes[0];
  EXPECT_TRUE(contains(notes[0], "at row 6001 (8 h 20 min 00 s)")) << notes[0];
  EXPECT_EQ(watch(fine(), [](int row, std::vector<double>& values) { values[1] += row == 6000 ? 18 : 0; }), Notes{})
      << "a spike, which the check of isolated values reports";
}

TEST(RepeatWatch, NeedsConstantMemoryForLongFiles) {
  const auto notes = watch(fine(), hold(1, 150'000, 299'999), 1e-4, 300'000);
  ASSERT_EQ(notes.size(), 1u) << "blocks were merged";
  EXPECT_TRUE(contains(notes[0], "in 150000 consecutive values, from row 150001 ")) << notes[0];
}

}  // namespace
}  // namespace gyrotherm::exchange
