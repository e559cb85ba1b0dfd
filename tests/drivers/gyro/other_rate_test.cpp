// SPDX-License-Identifier: Apache-2.0
/// Tests of gyros with another frame rate than described, and of bytes that are not frames of the stream.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <random>

#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A shipped stream with another frame rate, on a line with its own clock.
class UnitAtRate {
 public:
  /// `described_hz` is the rate in the rig file; 0 means the stream's own.
  UnitAtRate(const std::string& name, double rate_hz, double described_hz = 0) : rate_hz_(rate_hz) {
    const auto own = tests::shipped_stream(name);
    auto stream = parse_gyro_stream(own.text, name, {}, described_hz > 0 ? std::optional(described_hz) : std::nullopt);
    if (!stream) throw std::runtime_error(text(stream.error()));
    format_ = stream->frame;
    const auto* sequence = format_.find(FieldRole::sequence);
    if (sequence) step_ = static_cast<double>(sequence->step) * format_.rate_hz / rate_hz;
    auto made = std::make_unique<tests::FakeStream>();
    line_ = made.get();
    gyro_ = make_framed_gyro(format_, std::move(made), milliseconds(800), {}, &clock_);
  }
  void send(int frames) {
    for (; frames > 0; --frames, ++sent_) line_->say(frame());
  }
  void lose(int frames) { sent_ += frames; }
  void pass(Duration time) { clock_.advance(time); }
  [[nodiscard]] Gyro& gyro() { return *gyro_; }
  [[nodiscard]] Result<GyroCount> read_second() {
    send(static_cast<int>(rate_hz_));
    pass(kSecond);
    return gyro_->read(kSecond);
  }

 private:
  [[nodiscard]] std::vector<std::byte> frame() const {
    const auto* time = format_.find(FieldRole::timestamp);
    const auto* sequence = format_.find(FieldRole::sequence);
    const auto range = sequence && sequence->range != 0 ? sequence->range : std::uint64_t{1} << 32;
    const auto counted = static_cast<std::uint64_t>(std::llround(static_cast<double>(sent_) * step_));
    const double seconds_passed = 100 + static_cast<double>(sent_) / rate_hz_;
    return encode_frame(
        format_, {.axes = {{.value = 0.001}},
                  .sequence = static_cast<std::uint32_t>(counted % range),
                  .timestamp = time ? static_cast<std::uint64_t>(std::llround(seconds_passed / time->unit_s)) : 0});
  }

  double rate_hz_, step_ = 1;
  FrameFormat format_;
  VirtualClock clock_;
  tests::FakeStream* line_ = nullptr;
  std::unique_ptr<Gyro> gyro_;
  std::int64_t sent_ = 0;
};

/// The time or the sequence of each frame advances by a constant multiple of the described step.
TEST(OtherRate, IsNotReportedAsLostFrames) {
  const std::vector<std::pair<std::string, double>> units{
      {"vectornav", 50},       {"vectornav", 25},        {"vectornav", 200},
      {"hg1700-rawimusx", 50}, {"hg1700-rawimusx", 200}, {"hg1700-rawimusxa", 20},
      {"stim300", 125},        {"stim300", 500},         {"stim300", 1000}};
  for (const auto& [name, rate_hz] : units) {
    UnitAtRate unit(name, rate_hz);
    unit.send(2);
    EXPECT_TRUE(unit.gyro().wait_for_origin()) << name << " " << rate_hz;
    for (int second = 0; second < 3; ++second) {
      const auto count = unit.read_second();
      ASSERT_FALSE(count) << name << " " << rate_hz;
      EXPECT_EQ(count.error().kind, FaultKind::mismatch) << name << " " << rate_hz << ": " << count.error().what;
      EXPECT_TRUE(count.error().what.starts_with(fmt::format("sends {:.1f} frames per second", rate_hz)))
          << name << ": " << count.error().what;
    }
    EXPECT_EQ(unit.gyro().frames().lost, 0u) << name << " " << rate_hz;
  }
}

TEST(OtherRate, IsAcceptedIfRigFileStatesIt) {
  const std::vector<std::pair<std::string, double>> units{
      {"vectornav", 50}, {"vectornav", 200}, {"hg1700-rawimusx", 50}, {"stim300", 125}, {"stim300", 1000}};
  for (const auto& [name, rate_hz] : units) {
    UnitAtRate unit(name, rate_hz, rate_hz);
    unit.send(1);
    ASSERT_TRUE(unit.gyro().wait_for_origin()) << name;
    for (int second = 0; second < 3; ++second) {
      const auto count = unit.read_second();
      ASSERT_TRUE(count) << name << " " << rate_hz << ": " << text(count.error());
      EXPECT_NEAR(to_seconds(count->interval), 1, 1e-6) << name;
    }
  }
}

TEST(OtherRate, IsNotSeenInFramesThatAreLost) {
  for (const auto* name : {"vectornav", "hg1700-rawimusx", "stim300"}) {
    const auto rate_hz = tests::shipped_stream(name).frame.rate_hz;
    UnitAtRate unit(name, rate_hz);
    unit.send(10);
    ASSERT_TRUE(unit.gyro().wait_for_origin()) << name;
    for (int i = 0; i < static_cast<int>(rate_hz) / 5; ++i) {
      unit.lose(1);
      unit.send(4);
    }
    unit.pass(kSecond);
    const auto count = unit.gyro().read(kSecond);
    ASSERT_FALSE(count) << name;
    EXPECT_EQ(count.error().kind, FaultKind::corrupted) << name;
    EXPECT_EQ(count.error().what, fmt::format("{} frames lost", static_cast<int>(rate_hz) / 5)) << name;
  }
}

TEST(ForeignBytes, AreReportedWithCountAndFirstBytes) {
  std::mt19937 random(5);
  std::vector<std::byte> drawn(2000);
  for (auto& byte : drawn) byte = static_cast<std::byte>(random());
  const auto noise = drawn;
  const auto stim = encode_frame(tests::shipped_stream("stim300").frame, {.axes = {{.value = 1}}});
  auto repeated = stim;
  while (repeated.size() < 2000) repeated.insert(repeated.end(), stim.begin(), stim.end());
  const auto other = repeated;
  const std::vector<std::byte> zeros(2000);
  std::size_t checked = 0;
  for (const auto& name : tests::shipped_streams())
    for (const auto* bytes : {&noise, &other, &zeros})
      for (const std::size_t piece : {27u, 4096u}) {
        if (name.starts_with("stim300") && bytes == &other) continue;
        // Bytes without a check that count 0, 0, … do not lock.
        if (name == "kvh-dsp-1750" && bytes == &zeros) continue;
        auto made = std::make_unique<tests::FakeStream>();
        made->limit_read_size(piece);
        made->say(*bytes);
        const auto gyro = make_framed_gyro(tests::shipped_stream(name).frame, std::move(made), milliseconds(100));
        const auto taken = gyro->wait_for_origin();
        ASSERT_FALSE(taken) << name;
        EXPECT_EQ(taken.error().kind, FaultKind::corrupted) << name << ": " << taken.error().what;
        const auto first = fmt::format("{:02X} {:02X} {:02X}", static_cast<unsigned>((*bytes)[0]),
                                       static_cast<unsigned>((*bytes)[1]), static_cast<unsigned>((*bytes)[2]));
        EXPECT_TRUE(
            taken.error().what.starts_with(fmt::format("{} bytes received in 0.1 s, but no frame", bytes->size())))
            << name << ": " << taken.error().what;
        EXPECT_NE(taken.error().what.find(first), std::string::npos) << name << ": " << taken.error().what;
        EXPECT_NE(taken.error().what.find("check the baud rate and the stream file"), std::string::npos);
        EXPECT_EQ(gyro->wait_for_origin().error().kind, FaultKind::timeout) << "now nothing came";
        ++checked;
      }
  EXPECT_EQ(checked, 120u);
}

TEST(ForeignBytes, TimeOutIfShorterThanFrame) {
  const auto format = tests::shipped_stream("vectornav").frame;
  auto made = std::make_unique<tests::FakeStream>();
  made->say(encode_frame(format, {.axes = {{.value = 1}}}));
  auto half = encode_frame(format, {.axes = {{.value = 1}}});
  half.resize(20);
  auto* line = made.get();
  const auto gyro = make_framed_gyro(format, std::move(made), milliseconds(100));
  ASSERT_TRUE(gyro->wait_for_origin());
  line->say(half);
  EXPECT_EQ(gyro->read(kSecond).error().kind, FaultKind::timeout);
}

TEST(ConfigurationMessage, FailsEveryReadUntilSettingsAgree) {
  const auto format = tests::shipped_stream("stim300").frame;
  auto made = std::make_unique<tests::FakeStream>();
  auto* line = made.get();
  VirtualClock clock;
  const auto gyro = make_framed_gyro(format, std::move(made), milliseconds(800), {}, &clock);
  std::uint32_t sent = 0;
  const auto second = [&] {
    for (int i = 0; i < 250; ++i, ++sent)
      line->say(encode_frame(format, {.axes = {{.value = 0.5}}, .sequence = sent * 8 % 256}));
    clock.advance(kSecond);
  };
  second();
  ASSERT_TRUE(gyro->wait_for_origin());
  second();
  EXPECT_TRUE(gyro->read(kSecond));
  line->say(encode_settings(format, 0xBC, true));
  for (int i = 0; i < 3; ++i) {
    second();
    const auto count = gyro->read(kSecond);
    ASSERT_FALSE(count);
    EXPECT_EQ(count.error().kind, FaultKind::mismatch);
  }
  line->say(encode_settings(format, 0xBD, false));
  second();
  EXPECT_TRUE(gyro->read(kSecond));
}

}  // namespace
}  // namespace gyrotherm::drivers
