// SPDX-License-Identifier: Apache-2.0
// Tests of RTU replies among bytes that an idle bus, other units and echoing adapters put on the line.
#include <gtest/gtest.h>

#include "tests/drivers/line/rtu_on_a_line.hpp"
#include "tests/support/hex_bytes.hpp"

namespace gyrotherm::drivers {
namespace {

using ModbusRtuNoise = OnASimulatedLine;
using ModbusRtuEcho = OnASimulatedLine;

Bytes joined(Bytes first, const Bytes& second, const Bytes& third = {}) {
  first.insert(first.end(), second.begin(), second.end());
  first.insert(first.end(), third.begin(), third.end());
  return first;
}

void expect_every_function_works(Registers& registers) {
  EXPECT_EQ(registers.read(kHolding, 60, 2).value(), (Words{60, 61}));
  EXPECT_EQ(registers.read(ReadFunction::input_registers, 7, 1).value(), Words{7});
  EXPECT_EQ(registers.read(ReadFunction::coils, 0, 3).value(), (Words{0, 1, 0}));
  EXPECT_TRUE(registers.write(WriteFunction::one_register, 60, Words{200}));
  EXPECT_TRUE(registers.write(WriteFunction::registers, 60, Words{1, 2, 3}));
  EXPECT_TRUE(registers.write(WriteFunction::coil, 0, Words{1}));
}

TEST_F(ModbusRtuNoise, FindsTheReplyBetweenBytesOfAnIdleBus) {
  for (const auto number : std::initializer_list<std::uint8_t>{1, 0, 255})
    for (const char* before : {"", "FF", "00", "FF FF 00", "80 7F 00 FE"})
      for (const char* after : {"", "00", "FF 00"}) {
        SCOPED_TRACE(std::string(before) + " reply of unit " + std::to_string(number) + " " + after);
        auto link = usual();
        link.unit = number;
        connect(link);
        unit = [&](int, const ModbusRequest& request, const Bytes&) {
          line->arrive(kSoon, joined(tests::parse_hex_bytes(before), good(request), tests::parse_hex_bytes(after)));
        };
        asked_at.clear();
        expect_every_function_works(*registers);
        EXPECT_EQ(requests(), 6u) << "none is asked twice";
      }
}

TEST_F(ModbusRtuNoise, WaitsForTheReplyWhenNoiseComesLongBefore) {
  unit = [this](int, const ModbusRequest& request, const Bytes&) {
    line->arrive(milliseconds(1), {std::byte{0xFF}});
    line->arrive(milliseconds(90), {std::byte{0x01}});  // equal to the unit's number
    line->arrive(milliseconds(150), good(request));
  };
  EXPECT_EQ(registers->read(kHolding, 60, 2).value(), (Words{60, 61}));
  EXPECT_EQ(requests(), 1u);
}

TEST_F(ModbusRtuNoise, CostsNoTimeBetweenExchanges) {
  unit = [this](int, const ModbusRequest& request, const Bytes&) {
    line->arrive(kSoon, good(request));
    line->arrive(kSoon + milliseconds(1), {std::byte{0x00}});  // the driver is switched off
  };
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  const auto began = now();
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(registers->read(kHolding, 1, 1));
  EXPECT_LT(now() - began, 10 * milliseconds(20));
}

TEST_F(ModbusRtuNoise, NeverHidesAFalseCrc) {
  unit = [this](int, const ModbusRequest& request, const Bytes&) {
    auto reply = good(request);
    reply[3] ^= std::byte{0x10};
    line->arrive(kSoon, joined({std::byte{0xFF}}, reply, {std::byte{0x00}}));
  };
  EXPECT_EQ(registers->read(kHolding, 60, 2).error().what, "the reply has a wrong CRC");
  EXPECT_EQ(registers->write(WriteFunction::registers, 60, Words{1, 2}).error().kind, FaultKind::corrupted);
}

TEST_F(ModbusRtuNoise, EndsWithinTheLimitOnALineThatNeverFallsSilent) {
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  unit = [this](int, const ModbusRequest&, const Bytes&) {
    for (int i = 0; i < 3000; ++i)
      line->arrive(milliseconds(1) + i * std::chrono::microseconds(100), {std::byte{0xFF}});
  };
  const auto began = now();
  const auto words = registers->read(kHolding, 1, 1);
  EXPECT_EQ(words.error().kind, FaultKind::corrupted);
  EXPECT_EQ(words.error().what, "no reply among 768 bytes");
  EXPECT_LE(now() - began, milliseconds(1500));
}

TEST_F(ModbusRtuNoise, TreatsFrameAfterReplyAsLateAnswer) {
  unit = [this](int number, const ModbusRequest& request, const Bytes&) {
    auto old = request;
    old.address = 7;
    if (number == 0) return line->arrive(kSoon, joined(good(request), good(old)));
    line->arrive(kSoon, good(request));
  };
  EXPECT_EQ(registers->read(kHolding, 60, 1).value(), Words{60});
  const auto answered = now();
  EXPECT_EQ(registers->read(kHolding, 61, 1).value(), Words{61});
  EXPECT_GE(asked_at[1] - answered, kTimeout);
}

constexpr const char* kEchoMessage =
    "the line or its adapter echoes the request; set echo = true in the link table of the rig "
    "file";

void expect_echo(const Result<void>& written) {
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().kind, FaultKind::corrupted);
  EXPECT_EQ(written.error().what, kEchoMessage);
}

TEST_F(ModbusRtuEcho, IsReportedForWritesAsForReads) {
  for (const int delay_ms : {0, 10, 100})
    for (const bool is_noisy : {false, true}) {
      unit = [&](int, const ModbusRequest& request, const Bytes& frame) {
        line->arrive(milliseconds(1), is_noisy ? joined({std::byte{0xFF}}, frame) : frame);
        line->arrive(milliseconds(1 + delay_ms), good(request));
      };
      const auto fresh = [&] { connect(usual()); };
      fresh();
      expect_echo(registers->write(WriteFunction::one_register, 60, Words{200}));
      fresh();
      expect_echo(registers->write(WriteFunction::coil, 3, Words{1}));
      fresh();
      expect_echo(registers->write(WriteFunction::registers, 60, Words{1, 2}));
      fresh();
      EXPECT_EQ(registers->read(kHolding, 60, 2).error().what, kEchoMessage);
      EXPECT_EQ(registers->read(ReadFunction::input_registers, 60, 2).error().what, kEchoMessage);
    }
}

TEST_F(ModbusRtuEcho, IsNotAcceptedAsAnswerOfSilentUnit) {
  unit = [this](int, const ModbusRequest&, const Bytes& frame) { line->arrive(milliseconds(1), frame); };
  for (const auto function : {WriteFunction::one_register, WriteFunction::coil, WriteFunction::registers}) {
    connect(usual());
    EXPECT_FALSE(registers->write(function, 60, Words{1}));
  }
}

TEST_F(ModbusRtuEcho, IsNotAcceptedAsRefusalOfWrite) {
  unit = [this](int, const ModbusRequest&, const Bytes& frame) {
    line->arrive(milliseconds(1), frame);
    line->arrive(milliseconds(30), encode_rtu_exception(frame, 4));
  };
  connect(usual());
  EXPECT_FALSE(registers->write(WriteFunction::one_register, 60, Words{1}));
}

TEST_F(ModbusRtuEcho, IsReadIfLinkExpectsIt) {
  auto link = usual();
  link.echo = true;
  for (const int delay_ms : {0, 1, 60})
    for (const char* noise : {"", "FF", "00 00"}) {
      connect(link);
      unit = [&](int, const ModbusRequest& request, const Bytes& frame) {
        line->arrive({}, joined(tests::parse_hex_bytes(noise), frame));
        line->arrive(milliseconds(delay_ms), joined(tests::parse_hex_bytes(noise), good(request)));
      };
      asked_at.clear();
      expect_every_function_works(*registers);
      EXPECT_EQ(requests(), 6u);
    }
}

TEST_F(ModbusRtuEcho, FailsIfExpectedEchoIsWrongOrMissing) {
  auto link = usual();
  link.echo = true;
  connect(link);
  unit = [this](int, const ModbusRequest& request, const Bytes&) { line->arrive(kSoon, good(request)); };
  EXPECT_FALSE(registers->read(kHolding, 60, 2)) << "no echo";
  unit = [this](int, const ModbusRequest& request, Bytes frame) {
    frame[4] ^= std::byte{1};  // a collision
    line->arrive({}, frame);
    line->arrive(kSoon, good(request));
  };
  clock.advance(std::chrono::seconds(10));
  EXPECT_EQ(registers->read(kHolding, 60, 2).error().kind, FaultKind::corrupted);
  clock.advance(std::chrono::seconds(10));
  EXPECT_EQ(registers->write(WriteFunction::registers, 60, Words{1, 2}).error().kind, FaultKind::corrupted);
  unit = [](int, const ModbusRequest&, const Bytes&) {};
  clock.advance(std::chrono::seconds(10));
  EXPECT_EQ(registers->read(kHolding, 60, 2).error().kind, FaultKind::timeout);
}

TEST_F(ModbusRtuEcho, IsNotAnAnswerOfSilentUnit) {
  auto link = usual();
  link.echo = true;
  connect(link);
  unit = [this](int, const ModbusRequest&, const Bytes& frame) { line->arrive({}, frame); };
  for (const auto function : {WriteFunction::one_register, WriteFunction::coil, WriteFunction::registers}) {
    EXPECT_EQ(registers->write(function, 60, Words{1}).error().kind, FaultKind::timeout);
    clock.advance(std::chrono::seconds(10));
  }
}

TEST_F(ModbusRtuEcho, IsExcludedOncePerConnection) {
  EXPECT_TRUE(registers->write(WriteFunction::one_register, 60, Words{1}));
  EXPECT_EQ(requests(), 2u) << "a read shows that the line does not echo";
  EXPECT_TRUE(registers->write(WriteFunction::one_register, 60, Words{1}));
  EXPECT_EQ(requests(), 3u);
  line->disconnect();
  EXPECT_FALSE(registers->read(kHolding, 60, 1));
  line->recover();
  clock.advance(std::chrono::seconds(10));
  EXPECT_TRUE(registers->write(WriteFunction::one_register, 60, Words{1}));
  EXPECT_EQ(requests(), 5u);
}

}  // namespace
}  // namespace gyrotherm::drivers
