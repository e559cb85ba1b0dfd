// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/framed_gyro.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <stdexcept>

#include "core/clock.hpp"
#include "tests/drivers/gyro/virtual_gyro_frame.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A gyro with ten frames per second and 7 pulses per frame, on an in-memory line.
class OnFakeStream : public testing::Test {
 protected:
  OnFakeStream() { connect(virtual_gyro_frame(), &clock); }

  /// Connects the gyro. `host` is the clock of the line, if it has one.
  void connect(const FrameFormat& description, const Clock* host = nullptr) {
    format = description;
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    gyro = make_framed_gyro(format, std::move(made), milliseconds(100), {}, host);
  }
  void skip() {
    ++sequence, timestamp += 100'000, pulses += 7;
    clock.advance(milliseconds(100));
  }
  void send(int frames, bool good = true) {
    for (int i = 0; i < frames; ++i) {
      line->say(encode_frame(
          format, {.axes = {{.pulses = pulses}}, .sequence = sequence, .timestamp = timestamp, .good = good}));
      skip();
    }
  }
  void expect_second() {
    const auto count = gyro->read(seconds(1));
    ASSERT_TRUE(count) << text(count.error());
    EXPECT_EQ(count->pulses.at(0), 70);
    EXPECT_EQ(count->interval, seconds(1));
  }

  VirtualClock clock;
  FrameFormat format;
  tests::FakeStream* line{};
  std::unique_ptr<Gyro> gyro;
  std::uint32_t sequence = 0;
  std::uint64_t timestamp = 0;
  std::int64_t pulses = 0;
};
using FramedGyro = OnFakeStream;

TEST_F(FramedGyro, CountsFromOrigin) {
  EXPECT_EQ(gyro->wait_for_origin().error().kind, FaultKind::timeout);
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(10);
  expect_second();
}

/// The read must not be counted as a second without pulses.
TEST_F(FramedGyro, FailsFirstReadOfSingleFrame) {
  send(1);
  const auto first = gyro->read(seconds(1));
  ASSERT_FALSE(first);
  EXPECT_EQ(first.error().kind, FaultKind::corrupted);
  EXPECT_EQ(first.error().what, "the count starts again; the counts before it are lost");
  send(10);
  expect_second();
}

TEST_F(FramedGyro, CountsFramesOfFirstRead) {
  send(4);
  const auto count = gyro->read(seconds(1)).value();
  EXPECT_EQ(count.pulses.at(0), 21);
  EXPECT_EQ(count.interval, milliseconds(300));
}

TEST_F(FramedGyro, NoPulseIsCountedTwiceOrLost) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  for (int second = 0; second < 100; ++second) {
    send(10);
    expect_second();
  }
}

TEST_F(FramedGyro, FramesMayComeByteByByte) {
  line->limit_read_size(1);
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(10);
  expect_second();
}

TEST_F(FramedGyro, CountsWholeBacklog) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(1000);
  const auto count = gyro->read(seconds(1)).value();
  EXPECT_EQ(count.pulses.at(0), 7000);
  EXPECT_EQ(count.interval, seconds(100));
}

TEST_F(FramedGyro, EveryCounterMayWrap) {
  sequence = 0xFFFF - 4;
  timestamp = 0xFFFFFFFF - 450'000;
  pulses = 0x7FFFFFFF - 30;
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(10);
  expect_second();
}

TEST_F(FramedGyro, CountsDownAsWellAsUp) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  pulses = -30;
  timestamp = 1'000'000;
  send(1);
  EXPECT_EQ(gyro->read(seconds(1)).value().pulses.at(0), -30);
}

TEST_F(FramedGyro, CountsLostFramesAndRestarts) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(4);
  skip(), skip(), skip();
  send(3);
  const auto lost = gyro->read(seconds(1));
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, FaultKind::corrupted);
  EXPECT_EQ(lost.error().what, "3 frames lost");
  send(10);
  expect_second();
}

/// A line whose faults have no place.
class LineWithoutPlace final : public ByteStream {
 public:
  Result<std::size_t> read(std::span<std::byte>, Duration) override {
    return failure(FaultKind::timeout, "", "no data");
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    if (bytes.empty()) return {};
    return failure(FaultKind::timeout, "", "could not send");
  }
};

TEST(SilentGyro, IsNamedByItsFault) {
  const auto format = virtual_gyro_frame();
  const auto gyro = make_framed_gyro(format, std::make_unique<LineWithoutPlace>(), milliseconds(100), {}, nullptr);
  for (const auto& fault : {gyro->wait_for_origin().error(), gyro->read(seconds(1)).error()})
    EXPECT_EQ(text(fault), fmt::format("gyro {}: no data", format.name));
}

TEST_F(FramedGyro, TimesOutWhenSilentAndRestarts) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::timeout);
  for (int i = 0; i < 5; ++i) skip();
  send(1);
  EXPECT_EQ(gyro->read(seconds(1)).error().what, "the count starts again; the counts before it are lost");
  send(10);
  expect_second();
}

TEST_F(FramedGyro, StatesExactIntervalOfShortSecond) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(6);
  const auto count = gyro->read(seconds(1)).value();
  EXPECT_EQ(count.pulses.at(0), 42);
  EXPECT_EQ(count.interval, milliseconds(600));
}

TEST_F(FramedGyro, ReportsBrokenLineAsOwnFault) {
  line->disconnect();
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::disconnected);
}

constexpr const char* kIncrementsOnly = R"([frame]
name = "increments"
sync = [0xAA]
length = 6
[[frame.field]]
role = "increment"
type = "i24"
offset = 1
endian = "big"
[frame.check]
kind = "xor8"
offset = 5
)";

TEST_F(FramedGyro, IncrementsAreSummedOverTheHostsTime) {
  connect(frame_format_of(kIncrementsOnly), &clock);
  pulses = 1000;
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  clock.advance(milliseconds(2700));
  line->say(encode_frame(format, {.axes = {{.pulses = -5}}}));
  line->say(encode_frame(format, {.axes = {{.pulses = 12}}}));
  const auto count = gyro->read(seconds(1)).value();
  EXPECT_EQ(count.pulses.at(0), 7);
  EXPECT_EQ(count.interval, milliseconds(2700));
}

TEST_F(FramedGyro, CountsRejectedBytesAsLossWithoutSequence) {
  connect(frame_format_of(kIncrementsOnly));
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  auto garbled = encode_frame(format, {.axes = {{.pulses = 5}}});
  garbled[2] ^= std::byte{1};
  line->say(garbled);
  send(1);
  EXPECT_EQ(gyro->read(seconds(1)).error().what, "1 frames lost");
}

/// A gyro with increments of 5 and 100 frames per second, on a line with its own clock.
class FramedGyroByTheHost : public OnFakeStream {
 protected:
  FramedGyroByTheHost() {
    auto even = frame_format_of(kIncrementsOnly);
    even.rate_hz = 100;
    connect(even, &clock);
  }
  void pass(Duration time, int frames) {
    clock.advance(time);
    for (int i = 0; i < frames; ++i) line->say(encode_frame(format, {.axes = {{.pulses = 5}}}));
  }
  void expect(int frames, Duration interval) {
    const auto count = gyro->read(seconds(1));
    ASSERT_TRUE(count) << text(count.error());
    EXPECT_EQ(count->pulses.at(0), 5 * frames);
    EXPECT_EQ(count->interval, interval);
  }
  /// Reads three valid seconds.
  void run_in() {
    pass(seconds(1), 1);
    ASSERT_TRUE(gyro->wait_for_origin());
    for (int second = 0; second < 3; ++second) {
      pass(seconds(1), 100);
      expect(100, seconds(1));
    }
  }
};

TEST_F(FramedGyroByTheHost, LengthensLateSecondAndShortensNext) {
  run_in();
  pass(milliseconds(3510), 351);
  expect(351, milliseconds(3510));
  pass(milliseconds(490), 49);
  expect(49, milliseconds(490));
  pass(seconds(1), 100);
  expect(100, seconds(1));
}

/// The arrival time of the oldest frame is unknown after a silence.
TEST_F(FramedGyroByTheHost, AfterASilenceItCountsFromTheNewestFrame) {
  run_in();
  clock.advance(seconds(3));
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::timeout);
  pass(seconds(1), 67);
  EXPECT_EQ(gyro->read(seconds(1)).error().what, "the count starts again; the counts before it are lost");
  pass(seconds(1), 100);
  expect(100, seconds(1));
}

TEST_F(FramedGyroByTheHost, FramesThatAreMissingWithoutATraceAreAFault) {
  run_in();
  pass(seconds(1), 40);
  const auto lost = gyro->read(seconds(1));
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, FaultKind::corrupted);
  EXPECT_EQ(lost.error().what, "40 frames do not match the time in which they arrived: some were lost or late");
  pass(seconds(1), 100);
  EXPECT_EQ(gyro->read(seconds(1)).error().what, "the count starts again; the counts before it are lost");
  pass(seconds(1), 100);
  expect(100, seconds(1));
}

constexpr const char* kCountedFrames = R"([frame]
name = "counted"
sync = [0xAA]
length = 8
rate_hz = 1000
clock = "sequence"
[[frame.field]]
role = "sequence"
type = "u16"
offset = 1
[[frame.field]]
role = "increment"
type = "i24"
offset = 3
[frame.check]
kind = "xor8"
offset = 7
)";

/// A gyro with frames as its clock, 1000 per second by its description.
class FramedGyroByItsFrames : public OnFakeStream {
 protected:
  FramedGyroByItsFrames() {
    connect(frame_format_of(kCountedFrames), &clock);
    send(1);
    EXPECT_TRUE(gyro->wait_for_origin());
  }
  Result<GyroCount> read_after_a_second_of(int frames) {
    clock.advance(seconds(1));
    for (; frames > 0; --frames) line->say(encode_frame(format, {.axes = {{.pulses = 1}}, .sequence = sequence++}));
    return gyro->read(seconds(1));
  }
};

TEST_F(FramedGyroByItsFrames, FailsEveryReadAtDeviatingRate) {
  (void)read_after_a_second_of(100);
  for (int second = 0; second < 60; ++second) {
    const auto count = read_after_a_second_of(100);
    ASSERT_FALSE(count) << second;
    EXPECT_EQ(count.error().kind, FaultKind::mismatch);
    EXPECT_EQ(count.error().what,
              "sends 100.0 frames per second, but its stream file states 1000; set the unit, or rate_hz in [gyro] of "
              "the rig file");
  }
}

TEST_F(FramedGyroByItsFrames, ToleratesDelayedFrames) {
  for (const int frames : {1000, 1000, 1000, 400, 1600, 1000, 1030, 1030, 1030, 970}) {
    const auto count = read_after_a_second_of(frames);
    ASSERT_TRUE(count) << text(count.error());
    EXPECT_EQ(count->pulses.at(0), frames);
    EXPECT_EQ(count->interval, milliseconds(frames));
  }
}

/// The gyro declares the count of the frame unusable, so no later count is a difference from it.
TEST_F(FramedGyro, DoesNotCountFromFrameMarkedBad) {
  const auto send_bad_count = [this] {
    const auto counted = std::exchange(pulses, 0);
    send(1, false);
    pulses = counted + 7;
    EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::out_of_range);
  };
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  for (int repetition = 0; repetition < 2; ++repetition) {
    send(9);
    send_bad_count();
    send(10);
    const auto shorter = gyro->read(seconds(1));
    ASSERT_TRUE(shorter) << text(shorter.error());
    EXPECT_EQ(shorter->pulses.at(0), 63);
    EXPECT_EQ(shorter->interval, milliseconds(900)) << "from the first of the ten frames";
    send(10);
    expect_second();
  }
  send_bad_count();
  send(1);
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::corrupted) << "one frame is only an origin";
  send(10);
  expect_second();
  send(5);
  send(1, false);
  send(4);
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::out_of_range);
  send(10);
  expect_second();
}

TEST_F(FramedGyro, CountsItsFrames) {
  send(11);
  (void)gyro->read(seconds(1));
  skip();
  skip();
  send(9);
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::corrupted);
  send(10, false);
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::out_of_range);
  const FrameCount all{.seen = 30, .lost = 2, .bad = 10};
  EXPECT_EQ(gyro->frames(), all);
}

TEST_F(FramedGyro, ReportsRepeatedFrameAsFaultNotLoss) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(5);
  --sequence, timestamp -= 100'000, pulses -= 7;
  send(5);
  const auto twice = gyro->read(seconds(1));
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().kind, FaultKind::corrupted);
  EXPECT_TRUE(twice.error().what.starts_with("a frame was received twice")) << twice.error().what;
  EXPECT_EQ(gyro->frames().lost, 0u);
  send(10);
  expect_second();
}

TEST_F(FramedGyro, ReportsRestartedCounterAsFaultNotLoss) {
  sequence = 500, timestamp = 50'000'000, pulses = 3500;
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(5);
  sequence = 0, timestamp = 0, pulses = 0;
  send(5);
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::corrupted);
  EXPECT_EQ(gyro->frames().lost, 0u);
  send(10);
  expect_second();
}

/// Time jumps when a receiver learns the time of day. The pulses of one second must not be spread over an hour.
TEST_F(FramedGyro, ReportsTimeJump) {
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  for (const std::uint64_t jump : {2'000'000u, 1'000'000'000u, 0u - 1'000'000'000u}) {
    send(5);
    timestamp = (timestamp + jump) & 0xFFFFFFFF;
    send(5);
    const auto count = gyro->read(seconds(1));
    ASSERT_FALSE(count) << jump << ": an interval of " << to_seconds(count->interval) << " s";
    EXPECT_EQ(count.error().kind, FaultKind::corrupted);
    EXPECT_EQ(count.error().what, "the device clock jumped: it was set, or the gyro restarted");
    EXPECT_EQ(gyro->frames().lost, 0u);
    send(10);
    expect_second();
  }
}

/// Milliseconds described as microseconds would multiply each rate by a thousand.
TEST_F(FramedGyro, FailsEveryReadIfTimeUnitDiffers) {
  const auto second_of = [&](std::uint64_t stamp) {
    for (int i = 0; i < 10; ++i) {
      send(1);
      timestamp += stamp - 100'000;
    }
    return gyro->read(seconds(1));
  };
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  for (int second = 0; second < 60; ++second) ASSERT_TRUE(second_of(90'000)) << "a clock that is slow is believed";
  connect(format, &clock);
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  for (int second = 0; second < 2; ++second) (void)second_of(100);
  for (int second = 0; second < 60; ++second) {
    const auto count = second_of(100);
    ASSERT_FALSE(count) << second;
    EXPECT_EQ(count.error().kind, FaultKind::mismatch);
    EXPECT_EQ(count.error().what, "the time stamps advance by 0.001 s per second; check their unit in the stream file");
  }
}

constexpr const char* kTriad = R"([frame]
name = "triad"
sync = [0xAA]
length = 16
[[frame.field]]
role = "sequence"
type = "u8"
offset = 1
[[frame.field]]
role = "increment"
type = "i16"
offset = 2
axis = "x"
[[frame.field]]
role = "increment"
type = "i16"
offset = 4
axis = "y"
[[frame.field]]
role = "increment"
type = "i16"
offset = 6
axis = "z"
[[frame.field]]
role = "temperature"
type = "i16"
offset = 8
scale = { denominator = 100 }
[[frame.field]]
role = "value"
name = "discharge_current"
type = "u8"
offset = 10
unit = "mA"
scale = { denominator = 10 }
every = 4
turn = 1
[[frame.field]]
role = "status"
type = "u8"
offset = 11
mask = 0x01
good = 0x01
[[frame.field.rule]]
mask = 0x02
good = 0
verdict = "warning"
meaning = "warming up"
[frame.check]
kind = "sum8"
offset = 15
)";

FrameFormat triad() {
  const auto file = TomlTable::parse(kTriad, "triad.toml");
  auto format = read_frame_format(file->table("frame"), {"z", "x", "y"});
  if (const auto verdict = file->verdict(); !verdict) throw std::runtime_error(text(verdict.error()));
  return format;
}

/// A triad on an in-memory line.
class FramedTriad : public OnFakeStream {
 protected:
  FramedTriad() { connect(triad()); }
  struct Told {
    std::int64_t z = 3;
    double temperature = 25;
    bool good = true, flagged = false;
  };
  void tell(int frames, const Told& told) {
    for (int i = 0; i < frames; ++i)
      line->say(encode_frame(format, {.axes = {{.pulses = told.z}, {.pulses = 1}, {.pulses = -2}},
                                      .sequence = number++ % 256,
                                      .good = told.good,
                                      .flagged = told.flagged,
                                      .values = {told.temperature, 1.5}}));
  }
  std::uint32_t number = 0;
};

TEST_F(FramedTriad, ReturnsAllAxesAndHousekeeping) {
  tell(1, {.temperature = 90});
  ASSERT_TRUE(gyro->wait_for_origin());
  tell(50, {.temperature = 20});
  tell(50, {.temperature = 30.5, .flagged = true});
  const auto count = gyro->read(seconds(1));
  ASSERT_TRUE(count) << text(count.error());
  EXPECT_EQ(count->pulses, (std::vector<std::int64_t>{300, 100, -200}));
  ASSERT_EQ(count->values.size(), list_housekeeping(format).size());
  EXPECT_DOUBLE_EQ(count->values[0], 25.25) << "the origin's temperature is of the second before";
  EXPECT_DOUBLE_EQ(count->values[1], 1.5);
  EXPECT_EQ(count->values[2], 100);
  EXPECT_EQ(count->values[3], 50);
}

TEST_F(FramedTriad, AveragesEachSecondForItself) {
  tell(1, {});
  ASSERT_TRUE(gyro->wait_for_origin());
  tell(10, {.temperature = 20, .flagged = true});
  EXPECT_EQ(gyro->read(seconds(1)).value().values[0], 20);
  tell(10, {.temperature = 30});
  const auto values = gyro->read(seconds(1)).value().values;
  EXPECT_EQ(values[0], 30);
  EXPECT_EQ(values[2], 10);
  EXPECT_EQ(values[3], 0);
}

TEST_F(FramedTriad, ReturnsNanForMissingValue) {
  tell(2, {});
  ASSERT_TRUE(gyro->wait_for_origin());
  tell(2, {});  // turns 2 and 3
  const auto count = gyro->read(seconds(1));
  ASSERT_TRUE(count) << text(count.error());
  EXPECT_EQ(count->values[0], 25);
  EXPECT_TRUE(std::isnan(count->values[1]));
}

TEST_F(FramedTriad, FailsAllAxesWhenSecondHasLostOrBadFrames) {
  tell(1, {});
  ASSERT_TRUE(gyro->wait_for_origin());
  tell(5, {.temperature = 99});
  ++number;
  tell(5, {.temperature = 99});
  EXPECT_EQ(gyro->read(seconds(1)).error().what, "1 frames lost");
  tell(9, {.temperature = 99});
  tell(1, {.temperature = 99, .good = false});
  EXPECT_EQ(gyro->read(seconds(1)).error().kind, FaultKind::out_of_range);
  tell(10, {.temperature = 21});
  const auto count = gyro->read(seconds(1));
  ASSERT_TRUE(count) << text(count.error());
  EXPECT_EQ(count->pulses, (std::vector<std::int64_t>{30, 10, -20}));
  EXPECT_EQ(count->values[0], 21) << "of this second alone";
}

constexpr const char* kTwoMessages = R"([frame]
name = "two"
sync = [0xAA]
[frame.id]
offset = 1
[[frame.message]]
id = 1
length = 10
[[frame.message]]
id = 2
length = 10
[[frame.field]]
role = "sequence"
type = "u8"
offset = 2
[[frame.field]]
role = "timestamp"
type = "u16"
offset = 3
unit = "ms"
[[frame.field]]
role = "increment"
type = "i16"
offset = 5
axis = "x"
ids = [1]
[[frame.field]]
role = "increment"
type = "i16"
offset = 5
axis = "y"
ids = [2]
[[frame.field]]
role = "temperature"
type = "i8"
offset = 7
ids = [2]
[frame.check]
kind = "sum8"
offset = 9
)";

/// Two axes in alternating messages, one message per millisecond, with increments of 1 for x and 5 for y.
class FramedMultiplex : public OnFakeStream {
 protected:
  FramedMultiplex() {
    const auto file = TomlTable::parse(kTwoMessages, "two.toml");
    auto both = read_frame_format(file->table("frame"), {"x", "y"});
    if (const auto verdict = file->verdict(); !verdict) throw std::runtime_error(text(verdict.error()));
    connect(both, &clock);
    for (const auto* axis : {"x", "y"}) {
      const auto again = TomlTable::parse(kTwoMessages, "two.toml");
      alone.push_back(read_frame_format(again->table("frame"), {axis}));
    }
  }
  void say(int messages) {
    for (int i = 0; i < messages; ++i, ++number) {
      const auto axis = number % 2;
      line->say(encode_frame(alone[axis], {.axes = {{.pulses = axis == 0 ? 1 : 5}},
                                           .sequence = number % 256,
                                           .timestamp = number % 65536,
                                           .values = {25}}));
      clock.advance(milliseconds(1));
    }
  }
  std::vector<FrameFormat> alone;
  std::uint32_t number = 0;
};

TEST_F(FramedMultiplex, CountsWholeRounds) {
  say(2);
  ASSERT_TRUE(gyro->wait_for_origin());
  std::int64_t x = 0;
  for (int second = 0; second < 20; ++second) {
    say(1000 + (second % 3 == 0 ? 1 : 0));  // a read may end in between
    const auto count = gyro->read(seconds(1));
    ASSERT_TRUE(count) << text(count.error());
    EXPECT_EQ(count->pulses[0] * 5, count->pulses[1]);
    EXPECT_EQ(count->interval, milliseconds(2 * count->pulses[0]));
    EXPECT_EQ(count->values[0], 25);
    x += count->pulses[0];
  }
  EXPECT_EQ(x, (number - 2) / 2);
}

TEST_F(FramedMultiplex, CountsNextSecondAfterLostMessage) {
  say(2);
  ASSERT_TRUE(gyro->wait_for_origin());
  say(999);
  ++number;  // a lost y
  say(1);
  EXPECT_EQ(gyro->read(seconds(1)).error().what, "1 frames lost");
  say(1001);
  const auto count = gyro->read(seconds(1));
  ASSERT_TRUE(count) << text(count.error());
  EXPECT_EQ(count->pulses[0] * 5, count->pulses[1]);
  EXPECT_EQ(count->interval, milliseconds(2 * count->pulses[0]));
}

/// A gyro that is started by two commands and answers the second one.
class FramedGyroByCommand : public OnFakeStream {
 protected:
  FramedGyroByCommand() { connect_with("OK"); }
  void connect_with(const std::string& reply) {
    format = virtual_gyro_frame();
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [](std::string_view command) { return command == "go\r\n" ? "ready OK\r\n" : ""; };
    gyro = make_framed_gyro(format, std::move(made), milliseconds(100),
                            {.start = {{.send = "stop\r\n", .wait = milliseconds(1), .reply = ""},
                                       {.send = "go\r\n", .wait = milliseconds(50), .reply = reply}},
                             .stop = {{.send = "bye\r\n", .wait = {}, .reply = ""}}});
  }
  [[nodiscard]] std::vector<std::string> commands() const {
    auto heard = line->heard;
    std::erase(heard, "");
    return heard;
  }
};

TEST_F(FramedGyroByCommand, IsStartedOnce) {
  send(3);  // earlier frames
  ASSERT_TRUE(gyro->open());
  ASSERT_TRUE(gyro->open());
  EXPECT_EQ(commands(), (std::vector<std::string>{"stop\r\n", "go\r\n"}));
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  EXPECT_EQ(gyro->frames().seen, 1u) << "what came before it was started does not count";
}

TEST_F(FramedGyroByCommand, IsStartedByTheFirstReadAndAgainAfterASilence) {
  (void)gyro->read(seconds(1));
  EXPECT_EQ(commands().size(), 2u);
  (void)gyro->read(seconds(1));
  EXPECT_EQ(commands().size(), 2u) << "the frames of a slow gyro may arrive after the read that started it";
  (void)gyro->read(seconds(1));
  EXPECT_EQ(commands().size(), 4u) << "it may have been switched off";
}

TEST_F(FramedGyroByCommand, TimesOutWithoutReply) {
  connect_with("FINE");
  const auto opened = gyro->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, FaultKind::timeout);
  EXPECT_EQ(opened.error().what, "no reply \"FINE\" to \"go\" in 50 ms; received \"ready OK\"");
}

TEST_F(FramedGyroByCommand, SendsStopCommandAtEnd) {
  static std::string last;
  line->instrument = [](std::string_view command) {
    last = command;
    return command == "go\r\n" ? "OK" : "";
  };
  ASSERT_TRUE(gyro->open());
  gyro.reset();
  EXPECT_EQ(last, "bye\r\n");
}

}  // namespace
}  // namespace gyrotherm::drivers
