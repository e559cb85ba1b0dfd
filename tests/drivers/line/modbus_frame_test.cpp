// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/modbus_frame.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/drivers/line/words.hpp"
#include "tests/support/modbus_words.hpp"

namespace gyrotherm::drivers {
namespace {

Bytes hex(const char* text) {
  Bytes bytes;
  for (const char* at = text; *at != '\0';) {
    char* end = nullptr;
    bytes.push_back(static_cast<std::byte>(std::strtol(at, &end, 16)));
    at = *end == ' ' ? end + 1 : end;
  }
  return bytes;
}

const ModbusRequest kRead{.unit = 1, .function = ModbusFunction::read_holding, .address = 0x00A0, .count = 2};
const ModbusRequest kWriteOne{.transaction = 0x1234,
                              .unit = 1,
                              .function = ModbusFunction::write_single,
                              .address = 60,
                              .count = 1,
                              .words = {0xFE70}};
const ModbusRequest kWriteTwo{
    .unit = 1, .function = ModbusFunction::write_multiple, .address = 0x06CE, .count = 2, .words = {0x41B0, 0}};

// Published frames of a maker of chamber controllers (Yinhe).
TEST(ModbusFrame, EncodesThePublishedFrames) {
  EXPECT_EQ(encode_request(kRead), hex("00 00 00 00 00 06 01 03 00 A0 00 02"));
  EXPECT_EQ(encode_reply(kRead, Words{0x41B0, 0}), hex("00 00 00 00 00 07 01 03 04 41 B0 00 00"));
  EXPECT_EQ(encode_request(kWriteTwo), hex("00 00 00 00 00 0B 01 10 06 CE 00 02 04 41 B0 00 00"));
  EXPECT_EQ(encode_reply(kWriteTwo, {}), hex("00 00 00 00 00 06 01 10 06 CE 00 02"));
}

TEST(ModbusFrame, AcceptsEchoAsAnswerToSingleWrite) {
  EXPECT_EQ(encode_request(kWriteOne), hex("12 34 00 00 00 06 01 06 00 3C FE 70"));
  EXPECT_EQ(encode_reply(kWriteOne, {}), encode_request(kWriteOne));
}

TEST(ModbusFrame, DecodesReply) {
  const auto words = decode_reply(kRead, hex("00 00 00 00 00 07 01 03 04 41 B0 00 00"));
  ASSERT_TRUE(words) << text(words.error());
  EXPECT_EQ(*words, (Words{0x41B0, 0}));
  EXPECT_TRUE(decode_reply(kWriteTwo, hex("00 00 00 00 00 06 01 10 06 CE 00 02")));
  EXPECT_TRUE(decode_reply(kWriteOne, hex("12 34 00 00 00 06 01 06 00 3C FE 70")));
}

/// Flips each bit of the first `end` bytes of `reply`, one at a time, and expects corrupted. Modbus TCP does not
/// protect the words read, which follow.
void expect_every_falsified_field_corrupted(const ModbusRequest& request, const Bytes& reply, std::size_t end) {
  for (std::size_t at = 0; at < end; ++at)
    for (int bit = 0; bit < 8; ++bit) {
      auto falsified = reply;
      falsified[at] ^= static_cast<std::byte>(1 << bit);
      const auto words = decode_reply(request, falsified);
      ASSERT_FALSE(words) << "byte " << at << " bit " << bit;
      EXPECT_EQ(words.error().kind, FaultKind::corrupted) << "byte " << at << " bit " << bit;
    }
}

TEST(ModbusFrame, RefusesReplyWithAnyFalsifiedField) {
  expect_every_falsified_field_corrupted(kRead, encode_reply(kRead, Words{1, 2}), 9);
  expect_every_falsified_field_corrupted(kWriteOne, encode_reply(kWriteOne, {}), 12);
  expect_every_falsified_field_corrupted(kWriteTwo, encode_reply(kWriteTwo, {}), 12);
}

TEST(ModbusFrame, NamesFieldOfCorruptedReply) {
  auto reply = encode_reply(kRead, Words{1, 2});
  reply[6] = std::byte{2};
  EXPECT_EQ(decode_reply(kRead, reply).error().what,
            "unit of the reply is 2, expected 1, or returns_other_unit = true in the link table of the rig file");
}

TEST(ModbusFrame, RejectsReplyOfAnyOtherLength) {
  for (const auto& request : {kRead, kWriteOne, kWriteTwo}) {
    const auto reply = encode_reply(request, request.words.empty() ? Words{1, 2} : Words{});
    for (std::size_t size = 0; size < reply.size() + 4; ++size) {
      if (size == reply.size()) continue;
      auto other = reply;
      other.resize(size);
      // The header agrees with the size.
      if (size > 6) other[5] = static_cast<std::byte>(size - 6);
      ASSERT_FALSE(decode_reply(request, other)) << size;
      EXPECT_EQ(decode_reply(request, other).error().kind, FaultKind::corrupted) << size;
    }
  }
}

// According to its source code, the UMC1200 copies the length of the request into the reply.
TEST(ModbusFrame, ComparesOtherFieldsOfMiscountedReply) {
  auto write = kWriteTwo;
  const auto reply = hex("00 00 00 00 00 0B 01 10 06 CE 00 02");
  EXPECT_EQ(decode_reply(write, reply).error().what, "length of the reply is 11, expected 6");
  write.miscounted_reply = true;
  EXPECT_TRUE(decode_reply(write, reply));
  for (std::size_t at = 0; at < reply.size(); ++at) {
    if (at == 4 || at == 5) continue;
    auto falsified = reply;
    falsified[at] ^= std::byte{1};
    EXPECT_FALSE(decode_reply(write, falsified)) << "byte " << at;
  }
  auto read = kRead;
  read.miscounted_reply = true;
  EXPECT_EQ(decode_reply(read, hex("00 00 00 00 00 0B 01 03 04 41 B0 00 00")).error().what,
            "length of the reply is 11, expected 7");
}

TEST(ModbusFrame, NamesExceptionOfUnit) {
  const auto reply = encode_exception(encode_request(kRead), 2);
  EXPECT_EQ(reply, hex("00 00 00 00 00 03 01 83 02"));
  const auto words = decode_reply(kRead, reply);
  ASSERT_FALSE(words);
  EXPECT_EQ(words.error().kind, FaultKind::refused);
  EXPECT_EQ(words.error().what, "exception 2, illegal data address");
}

TEST(ModbusFrame, RejectsExceptionToOtherFunction) {
  EXPECT_EQ(decode_reply(kRead, hex("00 00 00 00 00 03 01 90 02")).error().kind, FaultKind::corrupted);
}

TEST(ModbusServer, TakesFramesFromAStreamOneByOne) {
  const auto frame = encode_request(kWriteTwo);
  for (std::size_t size = 0; size < frame.size(); ++size) {
    const auto length = frame_length(std::span(frame).first(size));
    ASSERT_TRUE(length);
    EXPECT_FALSE(*length) << size;
  }
  auto two = frame;
  two.insert(two.end(), frame.begin(), frame.end());
  EXPECT_EQ(frame_length(two).value().value(), frame.size());
}

TEST(ModbusServer, BytesThatCannotBecomeAFrameAreCorrupted) {
  EXPECT_EQ(frame_length(hex("00 00 00 01 00 06")).error().kind, FaultKind::corrupted) << "protocol";
  EXPECT_EQ(frame_length(hex("00 00 00 00 00 01")).error().kind, FaultKind::corrupted) << "too short";
  EXPECT_EQ(frame_length(hex("00 00 00 00 00 FF")).error().kind, FaultKind::corrupted) << "too long";
}

TEST(ModbusServer, DecodesWhatTheClientEncodes) {
  for (const auto& request : {kRead, kWriteOne, kWriteTwo}) {
    const auto decoded = decode_request(encode_request(request));
    ASSERT_TRUE(decoded) << text(decoded.error());
    EXPECT_EQ(decoded->transaction, request.transaction);
    EXPECT_EQ(decoded->unit, request.unit);
    EXPECT_EQ(decoded->function, request.function);
    EXPECT_EQ(decoded->address, request.address);
    EXPECT_EQ(decoded->count, request.count);
    EXPECT_EQ(decoded->words, request.words);
  }
}

TEST(ModbusServer, NamesTheExceptionToAnswerWith) {
  const auto code = [](const char* frame) { return decode_request(hex(frame)).error().what; };
  EXPECT_EQ(code("00 00 00 00 00 06 01 07 00 00 FF 00"), "1") << "no function of ours";
  EXPECT_EQ(code("00 00 00 00 00 06 01 05 00 00 FF 01"), "3") << "neither on nor off";
  EXPECT_EQ(code("00 00 00 00 00 06 01 03 FF FF 00 02"), "2") << "past the last register";
  EXPECT_EQ(code("00 00 00 00 00 06 01 03 00 00 00 00"), "3") << "no register";
  EXPECT_EQ(code("00 00 00 00 00 06 01 03 00 00 00 7E"), "3") << "126 registers";
  EXPECT_EQ(code("00 00 00 00 00 09 01 10 00 00 00 01 03 00 01"), "3") << "byte count";
  EXPECT_EQ(code("00 00 00 00 00 04 01 03 00 00"), "3") << "cut short";
}

}  // namespace
}  // namespace gyrotherm::drivers
