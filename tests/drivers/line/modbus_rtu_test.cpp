// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/drivers/line/rtu_on_a_line.hpp"
#include "tests/support/hex_bytes.hpp"
#include "tests/support/loopback_server.hpp"

namespace gyrotherm::drivers {
namespace {

using ModbusRtu = OnASimulatedLine;

TEST_F(ModbusRtu, ReadsAndWrites) {
  EXPECT_EQ(registers->read(kHolding, 60, 2).value(), (Words{60, 61}));
  EXPECT_EQ(registers->read(ReadFunction::input_registers, 7, 1).value(), Words{7});
  EXPECT_EQ(registers->read(ReadFunction::coils, 0, 3).value(), (Words{0, 1, 0}));
  EXPECT_TRUE(registers->write(WriteFunction::one_register, 60, Words{200}));
  EXPECT_TRUE(registers->write(WriteFunction::registers, 60, Words{1, 2, 3}));
  EXPECT_TRUE(registers->write(WriteFunction::coil, 0, Words{1}));
  EXPECT_EQ(requests(), 6u);
}

TEST_F(ModbusRtu, SingleWritesOfSeveralWordsGoOneByOne) {
  std::vector<std::pair<std::uint16_t, std::uint16_t>> written;
  unit = [&](int, const ModbusRequest& request, const Bytes&) {
    if (!is_read(request.function)) {
      EXPECT_EQ(request.function, ModbusFunction::write_single);
      written.emplace_back(request.address, request.words.front());
    }
    line->arrive(kSoon, good(request));
  };
  EXPECT_TRUE(registers->write(WriteFunction::one_register, 60, Words{7, 8}));
  EXPECT_EQ(written, (std::vector<std::pair<std::uint16_t, std::uint16_t>>{{60, 7}, {61, 8}}));
}

TEST_F(ModbusRtu, TakesAReplyInPieces) {
  unit = [this](int, const ModbusRequest& request, const Bytes&) {
    const auto reply = good(request);
    for (std::size_t i = 0; i < reply.size(); ++i) line->arrive(kSoon + milliseconds(10 * i), {reply[i]});
  };
  EXPECT_EQ(registers->read(kHolding, 60, 2).value(), (Words{60, 61}));
}

TEST_F(ModbusRtu, OnASlowLineAReplyIsNotOverBetweenTwoOfItsCharacters) {
  auto link = usual();
  link.serial.baud = 300;
  link.timeout = std::chrono::seconds(1);
  connect(link);
  unit = [this](int, const ModbusRequest& request, const Bytes&) {
    const auto reply = good(request);
    for (std::size_t i = 0; i < reply.size(); ++i) line->arrive(kSoon + milliseconds(34 * i), {reply[i]});
  };
  EXPECT_EQ(registers->read(kHolding, 60, 2).value(), (Words{60, 61}));
  EXPECT_EQ(requests(), 1u);
}

TEST_F(ModbusRtu, EndsIncompleteReplyEarly) {
  unit = [this](int, const ModbusRequest& request, const Bytes&) {
    auto reply = good(request);
    reply.pop_back();
    line->arrive(kSoon, reply);
  };
  EXPECT_EQ(registers->write(WriteFunction::one_register, 1, Words{1}).error().what, "the reply ends after 7 bytes");
  EXPECT_LT(now() - asked_at[0], kTimeout / 2);
}

TEST_F(ModbusRtu, DiscardsUnreadBytesBeforeRequest) {
  line->arrive({}, tests::parse_hex_bytes("01 03 02 00 EC B9 C9"));
  EXPECT_EQ(registers->read(kHolding, 60, 1).value(), Words{60});
  EXPECT_EQ(registers->read(kHolding, 61, 1).value(), Words{61});
}

TEST_F(ModbusRtu, NeverAcceptsLateReplyForNextRequest) {
  for (const int late_ms : {201, 250, 300, 399}) {
    unit = [&](int number, const ModbusRequest& request, const Bytes&) {
      line->arrive(number == 0 ? Duration(milliseconds(late_ms)) : kSoon, good(request));
    };
    asked_at.clear();
    EXPECT_EQ(registers->read(kHolding, 60, 1).value(), Words{60}) << "by the second try";
    EXPECT_EQ(registers->read(kHolding, 61, 1).value(), Words{61});
    EXPECT_EQ(requests(), 3u);
  }
}

TEST_F(ModbusRtu, WaitsForALateReplyAlsoAfterATryThatWasCutShort) {
  ModbusLink link = usual();
  link.timeout = milliseconds(600);  // too long for a second try
  connect(link);
  unit = [&](int number, const ModbusRequest& request, const Bytes&) {
    line->arrive(number < 2 ? 2 * link.timeout - milliseconds(1) : kSoon, good(request));
  };
  EXPECT_FALSE(registers->read(kHolding, 60, 1));
  EXPECT_FALSE(registers->read(kHolding, 70, 1));
  clock.advance(std::chrono::seconds(1));
  const auto third = registers->read(kHolding, 80, 1);
  EXPECT_TRUE(!third || *third == Words{80});
}

TEST_F(ModbusRtu, FindsItsReplyBehindThatOfAnotherUnit) {
  unit = [this](int number, ModbusRequest request, const Bytes&) {
    const auto own = good(request);
    request.unit = 2;
    request.address = 5;
    if (number == 0) line->arrive(milliseconds(1), good(request));
    line->arrive(kSoon, own);
  };
  EXPECT_EQ(registers->read(kHolding, 60, 1).value(), Words{60});
  EXPECT_EQ(requests(), 1u);
}

TEST_F(ModbusRtu, TwoEqualAnswersToAFirstWriteAreAnEchoAndAnAnswer) {
  unit = [this](int, const ModbusRequest& request, const Bytes&) {
    auto twice = good(request);
    const auto once = twice;
    twice.insert(twice.end(), once.begin(), once.end());
    line->arrive(kSoon, twice);
  };
  EXPECT_EQ(registers->write(WriteFunction::one_register, 1, Words{1}).error().kind, FaultKind::corrupted);
}

TEST_F(ModbusRtu, RejectsEchoOfOtherRegister) {
  unit = [this](int, ModbusRequest request, const Bytes&) {
    ++request.address;
    line->arrive(kSoon, good(request));
  };
  EXPECT_EQ(registers->write(WriteFunction::one_register, 60, Words{1}).error().what,
            "address of the reply is 61, expected 60");
}

TEST_F(ModbusRtu, RejectsEchoAsAnswer) {
  unit = [this](int, const ModbusRequest& request, const Bytes& frame) {
    line->arrive(milliseconds(1), frame);
    line->arrive(kSoon, good(request));
  };
  EXPECT_EQ(registers->read(kHolding, 0x200, 1).error().kind, FaultKind::corrupted) << "its address looks like a count";
  clock.advance(std::chrono::seconds(1));
  EXPECT_EQ(registers->read(kHolding, 60, 1).error().what,
            "the line or its adapter echoes the request; set echo = true in the link table of the rig "
            "file");
}

TEST_F(ModbusRtu, TimesOutWithinLimitWhenUnitIsSilent) {
  unit = [](int, const ModbusRequest&, const Bytes&) {};
  const auto began = now();
  const auto words = registers->read(kHolding, 2782, 2);
  EXPECT_EQ(text(words.error()), "modbus rtu line unit 1 read 2782+2: no reply in 200 ms");
  EXPECT_EQ(words.error().kind, FaultKind::timeout);
  EXPECT_EQ(requests(), 3u);
  EXPECT_LE(now() - began, milliseconds(1500));
}

TEST_F(ModbusRtu, EndsWithinLimitWhenLineNeverFallsSilent) {
  for (int i = 0; i < 400; ++i) line->arrive(milliseconds(10 * i), {std::byte{0x55}});
  const auto began = now();
  EXPECT_EQ(registers->read(kHolding, 1, 1).error().kind, FaultKind::corrupted);
  EXPECT_EQ(requests(), 0u);
  EXPECT_LE(now() - began, milliseconds(1500));
}

TEST_F(ModbusRtu, DoesNotRepeatFailedWrite) {
  unit = [](int, const ModbusRequest&, const Bytes&) {};
  EXPECT_EQ(registers->write(WriteFunction::registers, 2782, Words{1, 2}).error().kind, FaultKind::timeout);
  EXPECT_EQ(requests(), 1u);
}

TEST_F(ModbusRtu, UsesVendorNameOfException) {
  auto link = usual();
  link.busy_exceptions = {};
  link.exception_names = {{5, "write denied"}};
  connect(link);
  unit = [this](int number, const ModbusRequest&, const Bytes& frame) {
    line->arrive(kSoon, encode_rtu_exception(frame, number == 0 ? 2 : 5));
  };
  EXPECT_EQ(registers->read(kHolding, 1, 1).error().what, "exception 2, illegal data address");
  EXPECT_EQ(registers->write(WriteFunction::one_register, 1, Words{1}).error().what, "exception 5, write denied");
  EXPECT_EQ(requests(), 2u);
}

TEST_F(ModbusRtu, RefusesReadOnlyForMissingFunctionOrAddress) {
  auto link = usual();
  link.exception_names = {{7, "not ready"}, {9, "no such channel"}};
  link.busy_exceptions = {6, 7};
  connect(link);
  std::uint8_t exception = 0;
  unit = [&](int, const ModbusRequest&, const Bytes& frame) {
    line->arrive(kSoon, encode_rtu_exception(frame, exception));
  };
  const auto expect = [&](std::vector<std::uint8_t> codes, FaultKind of_a_read, FaultKind of_a_write) {
    for (const auto code : codes) {
      exception = code;
      EXPECT_EQ(registers->read(kHolding, 1, 1).error().kind, of_a_read) << +code;
      EXPECT_EQ(registers->write(WriteFunction::one_register, 1, Words{1}).error().kind, of_a_write) << +code;
    }
  };
  expect({1, 2}, FaultKind::refused, FaultKind::refused);
  expect({3, 8, 9}, FaultKind::out_of_range, FaultKind::refused);
  expect({4}, FaultKind::out_of_range, FaultKind::timeout);
  expect({5, 6, 7, 10, 11}, FaultKind::timeout, FaultKind::timeout);
}

TEST_F(ModbusRtu, RetriesReadOfBusyUnit) {
  unit = [this](int number, const ModbusRequest& request, const Bytes& frame) {
    line->arrive(kSoon, number < 3 ? encode_rtu_exception(frame, number == 0 ? 5 : 6) : good(request));
  };
  EXPECT_EQ(registers->read(kHolding, 4, 1).value(), Words{4});
  EXPECT_EQ(requests(), 4u);
}

TEST_F(ModbusRtu, ObservesPausesOfUnit) {
  auto link = usual();
  link.minimum_period = milliseconds(500);
  link.after_write = milliseconds(800);
  link.gap = milliseconds(20);
  connect(link);
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  EXPECT_GE(asked_at[1] - asked_at[0], milliseconds(500));
  EXPECT_TRUE(registers->write(WriteFunction::one_register, 1, Words{1}));
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  EXPECT_GE(asked_at[3] - asked_at[2], milliseconds(800));
  EXPECT_LT(asked_at[3] - asked_at[0], milliseconds(2000)) << "no longer than that";
  const auto idle = now();
  clock.advance(std::chrono::seconds(2));
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  EXPECT_EQ(asked_at[4] - idle, std::chrono::seconds(2) + milliseconds(20)) << "the gap alone";
}

TEST_F(ModbusRtu, WaitsThreeAndAHalfCharactersBetweenFrames) {
  auto link = usual();
  link.serial = {9600, 8, SerialParity::even, 1};
  EXPECT_NEAR(to_seconds(silence_between_frames(link)), 3.5 * 11 / 9600, 1e-6);
  link.serial.baud = 19200;
  EXPECT_NEAR(to_seconds(silence_between_frames(link)), 3.5 * 11 / 19200, 1e-6);
  link.serial.baud = 38400;
  EXPECT_EQ(silence_between_frames(link), std::chrono::microseconds(1750));
  link.gap = milliseconds(203);
  EXPECT_EQ(silence_between_frames(link), milliseconds(203));
}

TEST_F(ModbusRtu, ResynchronisesByLoopBack) {
  auto link = usual();
  link.loop_back = true;
  connect(link);
  std::vector<ModbusFunction> functions;
  Words numbers;
  unit = [&](int number, const ModbusRequest& request, const Bytes&) {
    functions.push_back(request.function);
    if (request.function == ModbusFunction::loop_back) numbers.push_back(request.words.front());
    if (number != 2) line->arrive(kSoon, good(request));
  };
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
  using enum ModbusFunction;
  EXPECT_EQ(functions, (std::vector{loop_back, read_holding, read_holding, loop_back, read_holding, read_holding}));
  EXPECT_EQ(numbers, (Words{1, 2})) << "none is used twice";
}

TEST_F(ModbusRtu, RestsAfterTheSecondFailureInARow) {
  line->disconnect();
  EXPECT_EQ(registers->read(kHolding, 1, 1).error().what, "gone");
  EXPECT_EQ(registers->read(kHolding, 1, 1).error().what, "gone");
  EXPECT_EQ(registers->read(kHolding, 1, 1).error().what, "gone; next try in 0.5 s");
  line->recover();
  EXPECT_FALSE(registers->read(kHolding, 1, 1));
  clock.advance(milliseconds(500));
  EXPECT_TRUE(registers->read(kHolding, 1, 1));
}

TEST(ModbusRtuOverTcp, EndsRestPeriodOfSocketAndRegisters) {
  TcpLine nobody;
  {
    const LoopbackServer closed([](auto) { return Answer{}; });
    nobody = closed.address();
  }
  const auto over_tcp = make_modbus(nobody, usual());
  const auto why = [&] { return over_tcp->read(kHolding, 1, 1).error().what; };
  EXPECT_EQ(why(), "Connection refused");
  EXPECT_EQ(why(), "Connection refused; next try in 0.5 s");
  over_tcp->end_rest();
  EXPECT_EQ(why(), "Connection refused");
}

/// A gateway delays the second packet until the first is acknowledged, as TCP may require.
TEST(ModbusRtuOverTcp, AcceptsReplyInTwoPieces) {
  const LoopbackServer gateway([](auto request) {
    const Bytes reply = good(decode_rtu_request(request).value());
    return Answer{{reply.begin(), reply.begin() + 3}, false, {reply.begin() + 3, reply.end()}};
  });
  const auto words = make_modbus(gateway.address(), usual())->read(kHolding, 40, 2);
  ASSERT_TRUE(words) << text(words.error());
  EXPECT_EQ(*words, (Words{40, 41}));
  EXPECT_EQ(gateway.requests(), 1);
}

}  // namespace
}  // namespace gyrotherm::drivers
