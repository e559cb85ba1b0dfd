// SPDX-License-Identifier: Apache-2.0
/// Tests both ends of every shipped gyro stream. The driver must sum the frames of the virtual gyro to the same angle.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/clock.hpp"
#include "core/random.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "simulator/servers/gyro_server.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::simulator {
namespace {

/// Angle per pulse of each axis.
constexpr double kArcsecPerPulse[] = {0.1, 0.25, -0.125};

/// Writer and driver of one stream, connected by a line in memory. The gyro turns at about 10, 20 and −5 °/h with
/// noise.
class WriterAndDriver {
 public:
  WriterAndDriver(const drivers::FrameFormat& format, double frames_a_second)
      : format_(format),
        rate_(frames_a_second),
        writer_(format, std::vector(kArcsecPerPulse, kArcsecPerPulse + format.axes.size())),
        pulses_(format.axes.size()) {
    auto made = std::make_unique<tests::FakeStream>();
    line_ = made.get();
    line_->say(writer_.lead_in());
    gyro_ = make_framed_gyro(format, std::move(made), std::chrono::milliseconds(50), {}, &clock_);
    for (std::size_t i = 0; i + 2 < list_housekeeping(format).size(); ++i) values_.push_back(0);
  }

  /// Advances by the first second. It ends with the origin from which the driver counts.
  Result<void> first_second() {
    advance_second();
    return gyro_->wait_for_origin();
  }
  /// Advances by one second and returns the count that the driver reads.
  Result<GyroCount> second() {
    advance_second();
    return gyro_->read(kSecond);
  }

  /// Returns the angle of each axis.
  [[nodiscard]] std::vector<double> angles_arcsec() const {
    std::vector<double> angles;
    for (std::size_t i = 0; i < pulses_.size(); ++i)
      angles.push_back(static_cast<double>(pulses_[i]) * kArcsecPerPulse[i]);
    return angles;
  }
  [[nodiscard]] double arcsec_per_count(std::size_t axis) const {
    return gyrotherm::drivers::arcsec_per_count(format_, axis).value_or(kArcsecPerPulse[axis]);
  }
  [[nodiscard]] FrameCount frames() const { return gyro_->frames(); }
  /// Returns the housekeeping of the last second.
  [[nodiscard]] const std::vector<double>& values() const { return values_; }
  /// Returns the resolution of the field of an axis, in arcsec per frame.
  [[nodiscard]] double resolution_arcsec(std::size_t axis) const {
    const auto& field = *format_.gyros()[axis];
    if (is_real(field.type)) return 1e-5;
    const double step = std::abs(field.scale.of(arcsec_per(field.unit, field.role).value_or(kArcsecPerPulse[axis])));
    return field.role == drivers::FieldRole::rate ? step / rate_ : step;
  }

 private:
  void advance_second() {
    constexpr double kPulses[] = {106, 80, 40};
    clock_.advance(kSecond);
    const auto from = pulses_;
    for (std::size_t axis = 0; axis < pulses_.size(); ++axis)
      pulses_[axis] += std::llround(kPulses[axis] + 3 * noise_.normal());
    send_housekeeping();
    std::vector<double> now(pulses_.size());
    for (int i = 1; i <= static_cast<int>(rate_); ++i) {
      const double share = i / rate_;
      for (std::size_t axis = 0; axis < now.size(); ++axis)
        now[axis] = static_cast<double>(from[axis]) + share * static_cast<double>(pulses_[axis] - from[axis]);
      line_->say(writer_.next(now, std::llround((seconds_ + share) * 1e6), 1 / rate_, values_));
    }
    ++seconds_;
  }
  /// Sets temperatures from -20 °C and all other values within the width of their fields.
  void send_housekeeping() {
    const auto fields = format_.values();
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto& field = *fields[i];
      const auto turn = static_cast<std::int64_t>(seconds_) % 7 + static_cast<std::int64_t>(i);
      values_[i] = field.role == drivers::FieldRole::temperature ? -20 + static_cast<double>(turn)
                   : is_real(field.type)                         ? 0.25 * static_cast<double>(turn)
                                         : apply_scale(field, {.whole = field.bits > 1 ? turn : 0});
    }
  }

  drivers::FrameFormat format_;
  double rate_;
  StreamWriter writer_;
  RandomStream noise_{1, RandomPurpose::angle_noise};
  tests::FakeStream* line_{};
  VirtualClock clock_;
  std::unique_ptr<drivers::Gyro> gyro_;
  std::vector<std::int64_t> pulses_;
  std::vector<double> values_;
  double seconds_{};
};

/// Requires that the mean values of the driver equal those sent in that second. Skips values that the stream sends more
/// rarely at this rate.
void expect_values(const WriterAndDriver& ends, const drivers::FrameFormat& format, const GyroCount& count,
                   double frames_a_second) {
  const auto names = list_housekeeping(format);
  ASSERT_EQ(count.values.size(), names.size());
  for (std::size_t i = 0; i < ends.values().size(); ++i) {
    if (std::isnan(count.values[i]))
      EXPECT_GT(format.values()[i]->every, frames_a_second) << names[i].name << ": the value is sent in rotation";
    else
      EXPECT_NEAR(count.values[i], ends.values()[i], 1e-6) << names[i].name;
  }
  if (names.empty()) return;
  EXPECT_EQ(count.values[names.size() - 2], std::floor(frames_a_second));
  EXPECT_EQ(count.values[names.size() - 1], 0);
}

void expect_exact_sum(const std::string& name, const drivers::FrameFormat& format, double frames_a_second,
                      int seconds) {
  SCOPED_TRACE(name);
  WriterAndDriver ends(format, frames_a_second);
  const auto origin = ends.first_second();
  ASSERT_TRUE(origin) << text(origin.error());
  const auto before = ends.angles_arcsec();
  std::vector<double> sums(format.axes.size());
  for (int i = 0; i < seconds; ++i) {
    const auto count = ends.second();
    ASSERT_TRUE(count) << text(count.error());
    ASSERT_NEAR(to_seconds(count->interval), 1, 1e-9);
    ASSERT_EQ(count->pulses.size(), sums.size());
    for (std::size_t axis = 0; axis < sums.size(); ++axis)
      sums[axis] += static_cast<double>(count->pulses[axis]) * ends.arcsec_per_count(axis);
    expect_values(ends, format, *count, frames_a_second);
  }
  const auto after = ends.angles_arcsec();
  for (std::size_t axis = 0; axis < sums.size(); ++axis)
    EXPECT_NEAR(sums[axis], after[axis] - before[axis], 1.001 * ends.resolution_arcsec(axis) + 1e-6 * seconds) << axis;
  const auto frames = ends.frames();
  EXPECT_EQ(frames.lost, 0u);
  EXPECT_EQ(frames.bad, 0u);
  EXPECT_GE(frames.seen, static_cast<std::uint64_t>((seconds + 1) * frames_a_second));
}

TEST(StreamWriter, SumsToExactAngleAtOneFramePerSecond) {
  for (const auto& name : tests::shipped_streams())
    expect_exact_sum(name, slow_to_one_frame_per_second(tests::whole_shipped_stream(name).frame), 1, 300);
}

TEST(StreamWriter, SumsToExactAngleAtOwnRate) {
  for (const auto& name : tests::shipped_streams()) {
    const auto format = tests::whole_shipped_stream(name).frame;
    expect_exact_sum(name, format, format.rate_hz > 0 ? format.rate_hz : 1, 10);
  }
}

TEST(StreamWriter, SumsToExactAngleForOneOfThreeAxes) {
  for (const auto* name : {"kvh-17xx-a", "hg1700-rawimusx", "stim300"})
    for (const auto* axis : {"x", "y", "z"})
      expect_exact_sum(name, slow_to_one_frame_per_second(tests::shipped_stream(name, {axis}).frame), 1, 20);
}

TEST(StreamWriter, DoesNotCompensateSkippedFrames) {
  for (const auto* name : {"kvh-17xx-a", "hg4930", "kvh-dsp-3000-ascii"}) {
    const auto format = slow_to_one_frame_per_second(tests::whole_shipped_stream(name).frame);
    const auto axes = format.axes.size();
    StreamWriter writer(format, std::vector(axes, 0.1));
    drivers::FrameDecoder decoder(format);
    decoder.feed(writer.lead_in());
    writer.skip(std::vector(axes, 1e6));
    decoder.feed(writer.next(std::vector(axes, 1e6 + 100), 1'000'000, 1));
    const auto* frame = decoder.take();
    ASSERT_TRUE(frame) << name;
    const auto& field = *format.gyro();
    for (const auto& axis : frame->axes)
      EXPECT_NEAR(axis.value.value() * drivers::arcsec_per(field.unit, field.role).value(), 10, 1e-4) << name;
  }
}

TEST(StreamWriter, UsesDefaultHousekeepingForMissingValues) {
  for (const auto& name : tests::shipped_streams()) {
    const auto format = slow_to_one_frame_per_second(tests::whole_shipped_stream(name).frame);
    StreamWriter writer(format, std::vector(format.axes.size(), 0.1));
    drivers::FrameDecoder decoder(format);
    decoder.feed(writer.lead_in());
    while (decoder.take()) continue;
    const std::vector<double> still(format.axes.size());
    const auto fields = format.values();
    const double no_number = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> first_is_none(fields.empty() ? 0 : 1, no_number);
    decoder.feed(writer.next(still, 1'000'000, 1, first_is_none));
    const auto* frame = decoder.take();
    // The driver needs more frames to synchronise.
    if (!frame) continue;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (frame->values[i]) {
        EXPECT_EQ(*frame->values[i], fields[i]->role == drivers::FieldRole::temperature ? 25 : 0) << name;
      } else {
        EXPECT_GT(fields[i]->every, 1u) << name << ' ' << fields[i]->name;
      }
    }
  }
}

}  // namespace
}  // namespace gyrotherm::simulator
