// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_sum.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/gyro/framed_gyro.hpp"
#include "tests/drivers/gyro/virtual_gyro_frame.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A frame with one gyro's field of this kind, a time stamp in ms and nothing else.
FrameFormat format_with(const std::string& field) {
  return frame_format_of(
      fmt::format("[frame]\nname = \"f\"\nsync = [1]\nlength = 16\n[[frame.field]]\n{}\noffset = 8\n"
                  "[[frame.field]]\nrole = \"timestamp\"\ntype = \"u32\"\noffset = 4\nunit = \"ms\"\n",
                  field)
          .c_str());
}

double arcsec_of(const FrameFormat& format, const std::vector<GyroFrame>& frames) {
  FrameSum sum(format);
  FrameTally tally;
  for (const auto& frame : frames) sum.add(frame, tally);
  return static_cast<double>(sum.counts(tally, tally.interval)) * arcsec_per_count(format).value();
}

TEST(FrameSum, ARateIsItsMeanOverTheMeasuredInterval) {
  const auto format = format_with("role = \"rate\"\ntype = \"f32\"\nunit = \"deg/h\"");
  // 10 °/h and 20 °/h over half a second: 15 arcsec/s * 0.5 s. The first frame's rate belongs to the time before.
  EXPECT_NEAR(
      arcsec_of(format, {{.timestamp = 0, .gyro = 99}, {.timestamp = 250, .gyro = 10}, {.timestamp = 500, .gyro = 20}}),
      7.5, 1e-6);
}

TEST(FrameSum, RealIncrementsAreSummed) {
  const auto format = format_with("role = \"increment\"\ntype = \"f64\"\nunit = \"rad\"");
  std::vector<GyroFrame> frames(1001, {.timestamp = 0, .gyro = 7.292115e-8});
  EXPECT_NEAR(arcsec_of(format, frames), 15.041067, 1e-5) << "a second of the Earth's rate";
}

TEST(FrameSum, AnIntegratedAngleMayWrapEitherWay) {
  const auto format = format_with("role = \"integrated_angle\"\ntype = \"f64\"\nunit = \"deg\"\nwraps_at = 360");
  const auto turned = [&](double from, double to) { return arcsec_of(format, {{.gyro = from}, {.gyro = to}}); };
  EXPECT_NEAR(turned(359.999, 0.001), 7.2, 2e-6);
  EXPECT_NEAR(turned(0.001, 359.999), -7.2, 2e-6);
  EXPECT_NEAR(turned(10, 11), 3600, 2e-6);
}

TEST(FrameSum, IntegerIncrementsKeepTheirExactWeight) {
  const auto format = tests::shipped_stream("hg1700-rawimusx").frame;
  EXPECT_DOUBLE_EQ(arcsec_per_count(format).value(), std::ldexp(180 * 3600 / 3.14159265358979323846, -33));
  EXPECT_FALSE(arcsec_per_count(tests::shipped_stream("pulse-count").frame))
      << "the rig file has the weight of a pulse";
}

TEST(FrameSum, CountersOfAnyWidthTurnBackTheShorterWay) {
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
      decoder.feed(encode_frame(format, {.pulses = truth}));
      FrameTally tally;
      sum.add(decoder.take().value(), tally);
      counted += sum.counts(tally, tally.interval);
    }
    EXPECT_EQ(counted, truth) << bits << " bits, seed " << seed;
  }
}

TEST(FrameSum, ALostFrameOfAStampedStreamIsSeenByItsTime) {
  auto format = format_with("role = \"increment\"\ntype = \"i32\"");
  format.rate_hz = 100;
  FrameSum sum(format);
  FrameTally tally;
  for (const std::uint64_t ms : {0, 10, 20, 50, 60}) sum.add({.pulses = 1, .timestamp = ms}, tally);
  EXPECT_EQ(tally.lost, 2u);
}

TEST(FrameSum, CountedFramesAreAClock) {
  const auto format = tests::shipped_stream("stim300").frame;  // 250 Hz, eight ticks of the counter a frame
  FrameSum sum(format);
  FrameTally tally;
  for (std::uint32_t i = 0; i <= 250; ++i) sum.add({.sequence = 8 * i % 256, .gyro = 1}, tally);
  EXPECT_EQ(tally.interval, seconds(1));
  EXPECT_EQ(tally.lost, 0u);
  EXPECT_NEAR(static_cast<double>(sum.counts(tally, tally.interval)) * 1e-6, 3600, 1e-6);
  sum.add({.sequence = 8 * 253 % 256, .gyro = 1}, tally);
  EXPECT_EQ(tally.lost, 2u);
}

/// Each shipped stream through the driver: a second of it, whatever the frames are.
TEST(GyroStream, EveryShippedOneGivesItsAngleThroughTheDriver) {
  for (const auto& name : tests::shipped_streams()) {
    const auto format = tests::shipped_stream(name).frame;
    const auto& field = *format.gyro();
    if (field.role == FieldRole::pulse_count) continue;
    auto made = std::make_unique<tests::FakeStream>();
    auto* line = made.get();
    const auto gyro = make_framed_gyro(format, std::move(made), seconds(5));
    const auto* sequence = format.find(FieldRole::sequence);
    const auto* time = format.find(FieldRole::timestamp);
    const auto frames = static_cast<std::uint64_t>(format.rate_hz);
    if (format.line) line->say("\r\n");
    std::uint64_t sent = 0;
    const auto send = [&](std::uint64_t count) {
      for (; count > 0; --count, ++sent)
        line->say(encode_frame(
            format,
            {.pulses = is_real(field.type) ? std::nullopt : std::optional<std::int64_t>(40),
             .sequence = sequence ? static_cast<std::uint32_t>(sent * sequence->step % sequence->range) : 0,
             .timestamp = time ? sent * static_cast<std::uint64_t>(1 / (format.rate_hz * time->unit_s) + 0.5) : 0,
             .gyro = 0.001}));
    };
    const double value = is_real(field.type) ? 0.001 : field.scale.of(40);
    const double arcsec = value * *arcsec_per(field.unit, field.role);
    send(format.lock_frames + 1);
    ASSERT_TRUE(gyro->take_origin());
    send(frames);
    const auto count = gyro->read(seconds(1));
    ASSERT_TRUE(count) << name << ": " << text(count.error());
    const double expected = field.role == FieldRole::rate ? arcsec : arcsec * static_cast<double>(frames);
    EXPECT_NEAR(static_cast<double>(count->pulses) * *arcsec_per_count(format), expected, 1e-6 * expected) << name;
    EXPECT_EQ(count->interval, seconds(1)) << name;
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
