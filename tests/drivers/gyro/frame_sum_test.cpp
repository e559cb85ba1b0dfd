// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_sum.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/clock.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "tests/drivers/gyro/virtual_gyro_frame.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Returns a format with a gyro field of this kind and a time stamp in ms.
FrameFormat format_with(const std::string& field) {
  return frame_format_of(
      fmt::format("[frame]\nname = \"f\"\nsync = [1]\nlength = 16\n[[frame.field]]\n{}\noffset = 8\n"
                  "[[frame.field]]\nrole = \"timestamp\"\ntype = \"u32\"\noffset = 4\nunit = \"ms\"\n",
                  field)
          .c_str());
}

GyroFrame read_as(double value, std::optional<std::uint64_t> ms = {}) {
  return {.axes = {{.value = value}}, .timestamp = ms};
}

double arcsec_of(const FrameFormat& format, const std::vector<GyroFrame>& frames) {
  FrameSum sum(format);
  FrameTally tally;
  for (const auto& frame : frames) sum.add(frame, tally);
  return static_cast<double>(sum.counts(tally, tally.interval).at(0)) * arcsec_per_count(format, 0).value();
}

TEST(FrameSum, AveragesRateOverMeasuredInterval) {
  const auto format = format_with("role = \"rate\"\ntype = \"f32\"\nunit = \"deg/h\"");
  // 10 °/h and 20 °/h over half a second: 15 arcsec/s * 0.5 s. The first frame's rate belongs to the time before.
  EXPECT_NEAR(arcsec_of(format, {read_as(99, 0), read_as(10, 250), read_as(20, 500)}), 7.5, 1e-6);
}

TEST(FrameSum, RealIncrementsAreSummed) {
  const auto format = format_with("role = \"increment\"\ntype = \"f64\"\nunit = \"rad\"");
  std::vector<GyroFrame> frames(1001, read_as(7.292115e-8));
  EXPECT_NEAR(arcsec_of(format, frames), 15.041067, 1e-5) << "a second of the Earth's rate";
}

TEST(FrameSum, UnwrapsIntegratedAngleInBothDirections) {
  const auto format = format_with("role = \"integrated_angle\"\ntype = \"f64\"\nunit = \"deg\"\nwraps_at = 360");
  const auto turned = [&](double from, double to) { return arcsec_of(format, {read_as(from), read_as(to)}); };
  EXPECT_NEAR(turned(359.999, 0.001), 7.2, 2e-6);
  EXPECT_NEAR(turned(0.001, 359.999), -7.2, 2e-6);
  EXPECT_NEAR(turned(10, 11), 3600, 2e-6);
}

TEST(FrameSum, IntegerIncrementsKeepTheirExactWeight) {
  const auto format = tests::shipped_stream("hg1700-rawimusx").frame;
  EXPECT_DOUBLE_EQ(arcsec_per_count(format, 0).value(), std::ldexp(180 * 3600 / 3.14159265358979323846, -33));
  EXPECT_FALSE(arcsec_per_count(tests::shipped_stream("pulse-count").frame, 0))
      << "the rig file has the weight of a pulse";
}

TEST(FrameSum, CountsShorterWayAcrossWrap) {
  const std::uint64_t seed = 5;
  std::mt19937_64 random(seed);
  for (const unsigned bits : {16u, 22u, 24u, 26u, 32u}) {
    const auto format = format_with(fmt::format("role = \"pulse_count\"\ntype = \"i32\"\nbits = {}", bits));
    std::int64_t truth = 0, counted = 0;
    FrameSum sum(format);
    for (int i = 0; i < 500; ++i) {
      const auto most = std::int64_t{1} << (bits - 1);
      truth += i == 0 ? 0 : static_cast<std::int64_t>(random() % (2 * most - 1)) - (most - 1);
      FrameDecoder decoder(format);
      decoder.feed(encode_frame(format, {.axes = {{.pulses = truth}}}));
      FrameTally tally;
      const auto* frame = decoder.take();
      ASSERT_TRUE(frame);
      sum.add(*frame, tally);
      counted += sum.counts(tally, tally.interval).at(0);
    }
    EXPECT_EQ(counted, truth) << bits << " bits, seed " << seed;
  }
}

TEST(FrameSum, DetectsLostFrameByTime) {
  auto format = format_with("role = \"increment\"\ntype = \"i32\"");
  format.rate_hz = 100;
  FrameSum sum(format);
  FrameTally tally;
  for (const std::uint64_t ms : {0, 10, 20, 50, 60}) sum.add({.axes = {{.pulses = 1}}, .timestamp = ms}, tally);
  EXPECT_EQ(tally.lost, 2u);
}

TEST(FrameSum, DetectsRepeatedFrameByTime) {
  auto format = format_with("role = \"increment\"\ntype = \"i32\"");
  using Times = std::vector<std::optional<std::uint64_t>>;
  const auto is_disordered = [&](double rate_hz, const Times& times) {
    format.rate_hz = rate_hz;
    FrameSum sum(format);
    FrameTally tally;
    for (const auto ms : times) sum.add({.axes = {{.pulses = 1}}, .timestamp = ms}, tally);
    return tally.is_disordered;
  };
  EXPECT_TRUE(is_disordered(100, {0, 10, 10, 20}));
  EXPECT_FALSE(is_disordered(1000, {0, 10, 10, 20})) << "two frames may have the same millisecond";
  EXPECT_FALSE(is_disordered(100, {0, 10, std::nullopt, 20})) << "not each has one";
  format = frame_format_of(
      "[frame]\nname = \"f\"\nsync = [1]\nlength = 24\n[[frame.field]]\nrole = \"increment\"\ntype = \"i32\"\noffset = "
      "16\n"
      "[[frame.field]]\nrole = \"timestamp\"\ntype = \"f64\"\noffset = 8\nunit = \"s\"\n");
  EXPECT_FALSE(is_disordered(100, {0, 10'000'000, 10'000'000, 20'000'000})) << "how fine a real time is nobody says";
}

TEST(FrameSum, CountedFramesAreAClock) {
  const auto format = tests::shipped_stream("stim300").frame;  // 250 Hz, eight ticks per frame
  FrameSum sum(format);
  FrameTally tally;
  for (std::uint32_t i = 0; i <= 250; ++i) sum.add({.axes = {{.value = 1}}, .sequence = 8 * i % 256}, tally);
  EXPECT_EQ(tally.interval, seconds(1));
  EXPECT_EQ(tally.lost, 0u);
  EXPECT_NEAR(static_cast<double>(sum.counts(tally, tally.interval).at(0)) * 1e-6, 3600, 1e-6);
  sum.add({.axes = {{.value = 1}}, .sequence = 8 * 253 % 256}, tally);
  EXPECT_EQ(tally.lost, 2u);
}

GyroFrame three(double x, double y, double z, std::uint64_t us) {
  return {.axes = {{.value = x}, {.value = y}, {.value = z}}, .timestamp = us};
}

TEST(FrameSum, EachAxisIsSummedForItself) {
  const auto format = tests::shipped_stream("kvh-17xx-b", {"x", "y", "z"}).frame;
  FrameSum sum(format);
  FrameTally tally;
  for (std::uint64_t i = 0; i <= 1000; ++i) sum.add(three(1e-6, i % 2 == 0 ? 3e-6 : -1e-6, -2e-6, 1000 * i), tally);
  EXPECT_EQ(tally.rounds, 1000u);
  EXPECT_EQ(tally.interval, seconds(1));
  const auto counts = sum.counts(tally, tally.interval);
  ASSERT_EQ(counts.size(), 3u);
  const double expected[] = {1e-3, 1e-3, -2e-3};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(static_cast<double>(counts[i]) * arcsec_per_count(format, i).value(),
                expected[i] * arcsec_per("rad", FieldRole::increment).value(), 1e-6);
}

TEST(FrameSum, AxesMayHaveKindsAndWeightsOfTheirOwn) {
  const auto file = TomlTable::parse(
      "[frame]\nname = \"f\"\nsync = [1]\nlength = 16\n"
      "[[frame.field]]\nrole = \"rate\"\ntype = \"i16\"\noffset = 1\nunit = \"deg/h\"\naxis = \"a\"\n"
      "[[frame.field]]\nrole = \"increment\"\ntype = \"i16\"\noffset = 3\nunit = \"arcsec\"\naxis = \"b\"\n"
      "scale = { denominator = 8 }\n"
      "[[frame.field]]\nrole = \"pulse_count\"\ntype = \"i16\"\noffset = 5\naxis = \"c\"\n"
      "[[frame.field]]\nrole = \"timestamp\"\ntype = \"u32\"\noffset = 8\nunit = \"ms\"\n",
      "frame.toml");
  const auto format = read_frame_format(file->table("frame"), {"a", "b", "c"});
  ASSERT_TRUE(file->verdict());
  EXPECT_EQ(arcsec_per_count(format, 0), 1e-6);
  EXPECT_EQ(arcsec_per_count(format, 1), 0.125);
  EXPECT_FALSE(arcsec_per_count(format, 2));
  FrameSum sum(format);
  FrameTally tally;
  FrameDecoder decoder(format);
  for (const std::int64_t i : {0, 1, 2})
    decoder.feed(encode_frame(format, {.axes = {{.pulses = 10 * i}, {.pulses = i}, {.pulses = 32767 + 5 * i}},
                                       .timestamp = static_cast<std::uint64_t>(500 * i)}));
  while (const auto* frame = decoder.take()) sum.add(*frame, tally);
  EXPECT_EQ(sum.counts(tally, tally.interval), (std::vector<std::int64_t>{15'000'000, 3, 10}));
}

/// Returns a message with one of the axes. Axis x is sent twice as often as y; `ms` is the time stamp.
GyroFrame only(std::size_t axis, std::int64_t pulses, std::uint64_t ms) {
  GyroFrame frame{.axes = {{}, {}}, .timestamp = ms};
  frame.axes[axis].pulses = pulses;
  return frame;
}

FrameFormat multiplexed() {
  const auto file = TomlTable::parse(
      "[frame]\nname = \"f\"\nsync = [1]\n[frame.id]\noffset = 1\n"
      "[[frame.message]]\nid = 1\nlength = 12\n[[frame.message]]\nid = 2\nlength = 12\n"
      "[[frame.field]]\nrole = \"increment\"\ntype = \"i16\"\noffset = 2\nids = [1]\naxis = \"x\"\n"
      "[[frame.field]]\nrole = \"increment\"\ntype = \"i16\"\noffset = 2\nids = [2]\naxis = \"y\"\n"
      "[[frame.field]]\nrole = \"timestamp\"\ntype = \"u32\"\noffset = 4\nunit = \"ms\"\n",
      "frame.toml");
  auto format = read_frame_format(file->table("frame"), {"x", "y"});
  if (const auto verdict = file->verdict(); !verdict) throw std::runtime_error(text(verdict.error()));
  return format;
}

TEST(FrameSum, AxesInSeveralMessagesCountInWholeRounds) {
  FrameSum sum(multiplexed());
  std::int64_t x = 0, y = 0, counted_x = 0, counted_y = 0;
  Duration interval{};
  const std::uint64_t seed = 3;
  std::mt19937_64 random(seed);
  FrameTally tally;
  for (std::uint64_t ms = 0; ms < 30'000; ++ms) {
    if (ms % 3 == 2) {
      sum.add(only(1, 7, ms), tally);
      y += ms > 2 ? 7 : 0;
    } else {
      sum.add(only(0, 1, ms), tally);
      x += ms > 2 ? 1 : 0;
    }
    if (random() % 40 != 0) continue;  // a read may end anywhere
    const auto counts = sum.counts(tally, tally.interval);
    counted_x += counts[0];
    counted_y += counts[1];
    interval += tally.interval;
    EXPECT_EQ(counts[0] * 7, counts[1] * 2) << "seed " << seed << " at " << ms;
    EXPECT_EQ(tally.interval, milliseconds(3 * tally.rounds)) << "seed " << seed << " at " << ms;
    tally = {};
  }
  const auto rest = sum.counts(tally, tally.interval);
  EXPECT_EQ(counted_x + rest[0], x);
  EXPECT_EQ(counted_y + rest[1], y);
  EXPECT_EQ(interval + tally.interval, milliseconds(29'997));
}

TEST(FrameSum, CountsFromEndOfDroppedRound) {
  FrameSum sum(multiplexed());
  FrameTally tally;
  for (std::uint64_t ms = 0; ms < 4; ++ms) sum.add(only(ms % 2, 1, ms), tally);
  EXPECT_EQ(sum.counts(tally, {}), (std::vector<std::int64_t>{1, 1}));
  sum.add(only(0, 1, 4), tally);  // y of this round is lost
  sum.drop_round();
  tally = {};
  sum.add(only(0, 1, 6), tally);
  EXPECT_EQ(tally.rounds, 0u);
  sum.add(only(1, 1, 7), tally);
  EXPECT_EQ(tally.rounds, 0u) << "it counted for more of x than of y";
  for (std::uint64_t ms = 8; ms < 12; ++ms) sum.add(only(ms % 2, 1, ms), tally);
  EXPECT_EQ(sum.counts(tally, {}), (std::vector<std::int64_t>{2, 2}));
  EXPECT_EQ(tally.interval, milliseconds(4));
}

TEST(FrameSum, DropsNothingBetweenRounds) {
  FrameSum sum(multiplexed());
  FrameTally tally;
  for (std::uint64_t ms = 0; ms < 2; ++ms) sum.add(only(ms % 2, 1, ms), tally);
  sum.drop_round();
  for (std::uint64_t ms = 2; ms < 4; ++ms) sum.add(only(ms % 2, 1, ms), tally);
  EXPECT_EQ(tally.rounds, 1u);
}

/// A message without an axis may carry the device's time, and a time may be missing once.
TEST(FrameSum, CountsNoLossForFrameWithoutTime) {
  const auto format = format_with("role = \"increment\"\ntype = \"i32\"");
  FrameSum sum(format);
  FrameTally tally;
  sum.add({.axes = {{.pulses = 1}}, .timestamp = 0}, tally);
  sum.add({.axes = {{.pulses = 1}}}, tally);
  sum.add({.axes = {{.pulses = 1}}, .timestamp = 20}, tally);
  EXPECT_EQ(tally.interval, milliseconds(20));
  EXPECT_EQ(sum.counts(tally, tally.interval).at(0), 2);
}

/// Reads one second of each shipped stream with the driver.
TEST(GyroStream, ReturnsAngleForEveryShippedStream) {
  int streams = 0;
  for (const auto& name : tests::shipped_streams()) {
    const auto format = tests::shipped_stream(name).frame;
    const auto& field = *format.gyro();
    if (field.role == FieldRole::pulse_count) continue;
    ++streams;
    auto made = std::make_unique<tests::FakeStream>();
    auto* line = made.get();
    VirtualClock clock;
    const auto gyro = make_framed_gyro(format, std::move(made), seconds(5), {}, &clock);
    const auto* sequence = format.find(FieldRole::sequence);
    const auto* time = format.find(FieldRole::timestamp);
    const auto frames = static_cast<std::uint64_t>(format.rate_hz);
    if (format.line) line->say("\r\n");
    std::uint64_t sent = 0;
    const auto send = [&](std::uint64_t count) {
      for (; count > 0; --count, ++sent)
        line->say(encode_frame(
            format,
            {.axes = {{.pulses = is_real(field.type) ? std::nullopt : std::optional<std::int64_t>(40), .value = 0.001}},
             .sequence = sequence ? static_cast<std::uint32_t>(sent * sequence->step % sequence->range) : 0,
             .timestamp = time ? sent * static_cast<std::uint64_t>(1 / (format.rate_hz * time->unit_s) + 0.5) : 0}));
    };
    const double value = is_real(field.type) ? 0.001 : field.scale.of(40);
    const double arcsec = value * *arcsec_per(field.unit, field.role);
    send(format.lock_frames + 1);
    ASSERT_TRUE(gyro->wait_for_origin());
    clock.advance(seconds(1));
    send(frames);
    const auto count = gyro->read(seconds(1));
    ASSERT_TRUE(count) << name << ": " << text(count.error());
    const double expected = field.role == FieldRole::rate ? arcsec : arcsec * static_cast<double>(frames);
    const double per_count = *arcsec_per_count(format, 0);
    EXPECT_NEAR(static_cast<double>(count->pulses.at(0)) * per_count, expected, 1e-6 * expected + per_count / 2)
        << name;
    EXPECT_EQ(count->interval, seconds(1)) << name;
  }
  EXPECT_GE(streams, 10);
}

/// Returns the means of two values, the number of averaged frames and the number of flagged frames.
FrameMeans means_over(const std::vector<GyroFrame>& frames) {
  static const auto format = frame_format_of(
      "[frame]\nname = \"f\"\nsync = [1]\nlength = 8\n[[frame.field]]\nrole = \"increment\"\ntype = \"u8\"\noffset = "
      "1\n"
      "[[frame.field]]\nrole = \"temperature\"\ntype = \"i8\"\noffset = 2\n"
      "[[frame.field]]\nname = \"current\"\nunit = \"mA\"\nrole = \"value\"\ntype = \"i8\"\noffset = 3\n");
  FrameMeans means(format);
  for (const auto& frame : frames) means.add(frame);
  return means;
}

TEST(FrameMeans, EachValueIsAveragedOverTheFramesThatHaveIt) {
  const auto means = means_over({{.values = {20, 1}}, {.values = {22, {}}}, {.values = {{}, 4}}, {.values = {{}, {}}}});
  EXPECT_EQ(means.values(), (std::vector<double>{21, 2.5, 3, 0})) << "the last frame carried nothing";
}

TEST(FrameMeans, AreNanForMissingValues) {
  const auto values = means_over({{.values = {20, {}}}}).values();
  EXPECT_EQ(values[0], 20);
  EXPECT_TRUE(std::isnan(values[1]));
  EXPECT_EQ(values[2], 1);
  const auto none = means_over({}).values();
  EXPECT_TRUE(std::isnan(none[0]) && std::isnan(none[1]));
  EXPECT_EQ(none[2], 0);
}

TEST(FrameMeans, CountsInvalidFrameWithoutAveragingIt) {
  const auto means = means_over({{.values = {20, 1}},
                                 {.good = false, .flagged = true, .values = {99, 99}},
                                 {.flagged = true, .values = {22, 3}},
                                 {.flagged = true, .values = {{}, {}}}});
  EXPECT_EQ(means.values(), (std::vector<double>{21, 2, 2, 3}));
}

TEST(FrameMeans, BeginEmpty) {
  auto means = means_over({{.flagged = true, .values = {20, 1}}});
  means.clear();
  means.add({.values = {10, 2}});
  EXPECT_EQ(means.values(), (std::vector<double>{10, 2, 1, 0}));
}

TEST(FrameMeans, HasNoValuesWhenFormatHasNoHousekeeping) {
  FrameMeans means(virtual_gyro_frame());
  means.add({.axes = {{.pulses = 1}}, .flagged = true});
  EXPECT_TRUE(means.values().empty());
}

/// Each second's means depend only on its own thousand frames.
TEST(FrameMeans, AreEmptyAfterClear) {
  auto means = means_over({});
  for (int second = 0; second < 100; ++second) {
    means.clear();
    for (int i = 0; i < 1000; ++i) means.add({.values = {second + 0.001 * (i - 499.5), 1e6}});
    EXPECT_NEAR(means.values()[0], second, 1e-9);
    EXPECT_EQ(means.values()[1], 1e6);
    EXPECT_EQ(means.values()[2], 1000);
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
