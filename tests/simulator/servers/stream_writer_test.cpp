// SPDX-License-Identifier: Apache-2.0
/// Every shipped gyro stream from both ends: what the virtual gyro writes, the driver adds up to the same angle.
#include <gtest/gtest.h>

#include <cmath>

#include "core/random.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "simulator/servers/gyro_server.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr double kArcsecPerPulse = 0.1;

/// A gyro of one stream that turns at about 10 °/h with noise, written to a driver on a line in memory.
class BothEnds {
 public:
  BothEnds(const drivers::FrameFormat& format, double frames_a_second)
      : format_(format), rate_(frames_a_second), writer_(format, kArcsecPerPulse) {
    auto made = std::make_unique<tests::FakeStream>();
    line_ = made.get();
    line_->say(writer_.lead_in());
    gyro_ = make_framed_gyro(format, std::move(made), std::chrono::milliseconds(50));
  }

  /// Lets a second pass, which ends with the origin.
  Result<void> first_second() {
    pass_second();
    return gyro_->take_origin();
  }
  /// Lets a second pass, and reads it.
  Result<PulseCount> second() {
    pass_second();
    return gyro_->read(kSecond);
  }

  [[nodiscard]] double angle_arcsec() const { return static_cast<double>(pulses_) * kArcsecPerPulse; }
  [[nodiscard]] double arcsec_per_count() const {
    return gyrotherm::drivers::arcsec_per_count(format_).value_or(kArcsecPerPulse);
  }
  [[nodiscard]] FrameCount frames() const { return gyro_->frames(); }
  /// What one step of the gyro's field is, in arcsec of one frame.
  [[nodiscard]] double resolution_arcsec() const {
    const auto& field = *format_.gyro();
    if (is_real(field.type)) return 1e-5;
    const double step = field.scale.of(arcsec_per(field.unit, field.role).value_or(kArcsecPerPulse));
    return field.role == drivers::FieldRole::rate ? step / rate_ : step;
  }

 private:
  void pass_second() {
    const auto from = pulses_;
    pulses_ += std::llround(106 + 3 * noise_.normal());
    for (int i = 1; i <= static_cast<int>(rate_); ++i) {
      const double share = i / rate_;
      line_->say(writer_.next(static_cast<double>(from) + share * static_cast<double>(pulses_ - from),
                              std::llround((seconds_ + share) * 1e6), 1 / rate_));
    }
    ++seconds_;
  }

  drivers::FrameFormat format_;
  double rate_;
  StreamWriter writer_;
  RandomStream noise_{1, RandomPurpose::angle_noise};
  tests::FakeStream* line_{};
  std::unique_ptr<drivers::Gyro> gyro_;
  std::int64_t pulses_{};
  double seconds_{};
};

void expect_exact_sum(const std::string& name, const drivers::FrameFormat& format, double frames_a_second,
                      int seconds) {
  SCOPED_TRACE(name);
  BothEnds ends(format, frames_a_second);
  const auto origin = ends.first_second();
  ASSERT_TRUE(origin) << text(origin.error());
  const double before = ends.angle_arcsec();
  double sum = 0;
  for (int i = 0; i < seconds; ++i) {
    const auto count = ends.second();
    ASSERT_TRUE(count) << text(count.error());
    ASSERT_NEAR(to_seconds(count->interval), 1, 1e-9);
    sum += static_cast<double>(count->pulses) * ends.arcsec_per_count();
  }
  EXPECT_NEAR(sum, ends.angle_arcsec() - before, 1.001 * ends.resolution_arcsec() + 1e-6 * seconds);
  const auto frames = ends.frames();
  EXPECT_EQ(frames.lost, 0u);
  EXPECT_EQ(frames.bad, 0u);
  EXPECT_GE(frames.seen, static_cast<std::uint64_t>((seconds + 1) * frames_a_second));
}

TEST(StreamWriter, AtOneFrameASecondEveryShippedStreamAddsUpExactly) {
  for (const auto& name : tests::shipped_streams())
    expect_exact_sum(name, at_one_frame_a_second(tests::shipped_stream(name).frame), 1, 300);
}

TEST(StreamWriter, AtItsOwnRateEveryShippedStreamAddsUpExactly) {
  for (const auto& name : tests::shipped_streams()) {
    const auto format = tests::shipped_stream(name).frame;
    expect_exact_sum(name, format, format.rate_hz > 0 ? format.rate_hz : 1, 10);
  }
}

TEST(StreamWriter, FramesThatWentToNobodyAreNotMadeUpFor) {
  for (const auto* name : {"kvh-17xx-a", "hg4930", "kvh-dsp-3000-ascii"}) {
    const auto format = at_one_frame_a_second(tests::shipped_stream(name).frame);
    StreamWriter writer(format, kArcsecPerPulse);
    drivers::FrameDecoder decoder(format);
    decoder.feed(writer.lead_in());
    writer.skip(1e6);
    decoder.feed(writer.next(1e6 + 100, 1'000'000, 1));
    const auto frame = decoder.take();
    ASSERT_TRUE(frame) << name;
    const auto& field = *format.gyro();
    EXPECT_NEAR(frame->gyro.value() * drivers::arcsec_per(field.unit, field.role).value(), 10, 1e-4) << name;
  }
}

}  // namespace
}  // namespace gyrotherm::simulator
