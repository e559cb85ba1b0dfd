// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "drivers/line/modbus_frame.hpp"
#include "tests/drivers/line/words.hpp"
#include "tests/support/hex_bytes.hpp"
#include "tests/support/modbus_words.hpp"

namespace gyrotherm::drivers {
namespace {

using enum ModbusFunction;

ModbusRequest read_of(std::uint8_t unit, std::uint16_t address, std::uint16_t count) {
  return {.unit = unit, .function = read_holding, .address = address, .count = count};
}
ModbusRequest write_of(std::uint8_t unit, std::uint16_t address, std::uint16_t word) {
  return {.unit = unit, .function = write_single, .address = address, .count = 1, .words = {word}};
}
ModbusRequest switch_of(std::uint8_t unit, std::uint16_t address) {
  return {.unit = unit, .function = write_coil, .address = address, .count = 1, .words = {1}};
}

struct Golden {
  ModbusRequest request;
  const char* asked;
  const char* answered;  ///< empty: not published
  Words words;
};

void expect_golden(const Golden& golden) {
  const auto& request = golden.request;
  EXPECT_EQ(tests::format_hex(encode_rtu_request(request)), golden.asked);
  const auto heard = decode_rtu_request(tests::parse_hex_bytes(golden.asked));
  ASSERT_TRUE(heard) << golden.asked;
  EXPECT_EQ(encode_rtu_request(*heard), tests::parse_hex_bytes(golden.asked));
  if (*golden.answered == '\0') return;
  EXPECT_EQ(tests::format_hex(encode_rtu_reply(request, golden.words)), golden.answered);
  const auto answer = decode_rtu_answer(request, tests::parse_hex_bytes(golden.answered));
  ASSERT_TRUE(answer) << golden.answered << " " << text(answer.error());
  EXPECT_EQ(answer->words, golden.words) << golden.answered;
  EXPECT_EQ(answer->exception, 0);
}

// Published in the CSZ EZT-570i User Communication Reference Manual, and computed by its rules.
TEST(ModbusRtuFrame, MatchesManualOfEzt570i) {
  expect_golden({read_of(1, 61, 1), "01 03 00 3D 00 01 15 C6", "01 03 02 00 EC B9 C9", {236}});
  expect_golden({read_of(1, 60, 2), "01 03 00 3C 00 02 04 07", "01 03 04 01 90 01 48 FA 44", {400, 328}});
  expect_golden({write_of(1, 60, 200), "01 06 00 3C 00 C8 48 50", "01 06 00 3C 00 C8 48 50", {}});
  expect_golden({read_of(1, 0, 60), "01 03 00 00 00 3C 45 DB", "", {}});
  expect_golden({read_of(1, 60, 60), "01 03 00 3C 00 3C 85 D7", "", {}});
  expect_golden({read_of(1, 120, 60), "01 03 00 78 00 3C C5 C2", "", {}});
  expect_golden({read_of(1, 180, 1), "01 03 00 B4 00 01 C4 2C", "", {}});
  expect_golden({write_of(1, 60, 0xFE70), "01 06 00 3C FE 70 08 42", "", {}});
  expect_golden({write_of(1, 22, 1), "01 06 00 16 00 01 A9 CE", "", {}});
  expect_golden({write_of(1, 37, 1), "01 06 00 25 00 01 59 C1", "", {}});
  expect_golden({write_of(1, 24, 4), "01 06 00 18 00 04 08 0E", "", {}});
  expect_golden({write_of(1, 24, 2), "01 06 00 18 00 02 88 0C", "", {}});
}

TEST(ModbusRtuFrame, EncodesBlockWriteOfEzt570i) {
  const ModbusRequest header{.unit = 1,
                             .function = write_multiple,
                             .address = 200,
                             .count = 15,
                             .words = {0, 0, 0, 0, 0x454A, 0x4453, 0x3232, 0x2041, 0x2020, 1, 10, 0, 0, 0, 0}};
  expect_golden(
      {header,
       "01 10 00 C8 00 0F 1E 00 00 00 00 00 00 00 00 45 4A 44 53 32 32 20 41 20 20 00 01 00 0A 00 00 00 00 00 00 "
       "00 00 3E B4",
       "01 10 00 C8 00 0F 01 F3",
       {}});
}

TEST(ModbusRtuFrame, MatchesManualsOfSamwon) {
  expect_golden({read_of(1, 0, 2), "01 03 00 00 00 02 C4 0B", "01 03 04 00 FA 03 E8 DA BC", {250, 1000}});
  expect_golden({write_of(1, 99, 2), "01 06 00 63 00 02 F8 15", "01 06 00 63 00 02 F8 15", {}});
  expect_golden({read_of(1, 0, 3), "01 03 00 00 00 03 05 CB", "01 03 06 01 ED 00 00 00 6C 8C 9E", {493, 0, 108}});
}

TEST(ModbusRtuFrame, AddressesUnitZeroOfTt5166) {
  expect_golden({write_of(0, 38, 220), "00 06 00 26 00 DC 68 49", "00 06 00 26 00 DC 68 49", {}});
  expect_golden({write_of(0, 39, 550), "00 06 00 27 02 26 B8 AA", "00 06 00 27 02 26 B8 AA", {}});
  expect_golden({read_of(0, 0, 1), "00 03 00 00 00 01 85 DB", "00 03 02 08 98 83 EE", {2200}});
  expect_golden({read_of(0, 3, 1), "00 03 00 03 00 01 75 DB", "", {}});
  expect_golden({switch_of(0, 0), "00 05 00 00 FF 00 8D EB", "00 05 00 00 FF 00 8D EB", {}});
  expect_golden({switch_of(0, 1), "00 05 00 01 FF 00 DC 2B", "00 05 00 01 FF 00 DC 2B", {}});
}

TEST(ModbusRtuFrame, EchoesNumberOfLoopBack) {
  const ModbusRequest loop{.unit = 1, .function = loop_back, .count = 1, .words = {0xA537}};
  const auto frame = encode_rtu_request(loop);
  EXPECT_EQ(tests::format_hex(std::span(frame).first(6)), "01 08 00 00 A5 37");
  EXPECT_EQ(encode_rtu_reply(loop, {}), frame);
  EXPECT_TRUE(decode_rtu_answer(loop, frame));
  auto other = loop;
  other.words = {0xA538};
  EXPECT_EQ(decode_rtu_answer(other, frame).error().kind, FaultKind::corrupted);
}

// Modbus Application Protocol V1.1b3, section 6.1: coils 20 to 38.
TEST(ModbusRtuFrame, ReadsBitsFromTheLowestUp) {
  const ModbusRequest coils{.unit = 1, .function = read_coils, .address = 19, .count = 19};
  auto reply = tests::parse_hex_bytes("01 01 03 CD 6B 05");
  append_rtu_crc(reply);
  const Words bits{1, 0, 1, 1, 0, 0, 1, 1, 1, 1, 0, 1, 0, 1, 1, 0, 1, 0, 1};
  EXPECT_EQ(decode_rtu_answer(coils, reply)->words, bits);
  EXPECT_EQ(encode_rtu_reply(coils, bits), reply);
}

TEST(ModbusRtuFrame, AcceptsExceptionAsAnswer) {
  const auto asked = read_of(7, 100, 1);
  const auto reply = encode_rtu_exception(encode_rtu_request(asked), 2);
  EXPECT_EQ(tests::format_hex(std::span(reply).first(3)), "07 83 02");
  EXPECT_EQ(decode_rtu_answer(asked, reply)->exception, 2);
  EXPECT_EQ(words_of(*decode_rtu_answer(asked, reply)).error().what, "exception 2, illegal data address");
  EXPECT_EQ(rtu_answer_size(asked, std::span(reply).first(2))->value(), 5u);
}

TEST(ModbusRtuFrame, AcceptsFunctionFourForThreeOnlyIfUnitDoesSo) {
  auto asked = read_of(1, 0, 1);
  auto by_four = asked;
  by_four.function = read_input;
  const auto reply = encode_rtu_reply(by_four, Words{7});
  EXPECT_EQ(decode_rtu_answer(asked, reply).error().what, "function of the reply is 4, expected 3");
  asked.either_read_function = true;
  EXPECT_EQ(decode_rtu_answer(asked, reply)->words, Words{7});
}

TEST(ModbusRtuFrame, RejectsReplyByFirstBytes) {
  const auto asked = read_of(1, 60, 2);
  const auto fault = [&](const char* bytes) {
    return rtu_answer_size(asked, tests::parse_hex_bytes(bytes)).error().what;
  };
  EXPECT_EQ(fault("02"), "unit of the reply is 2, expected 1");
  EXPECT_EQ(fault("01 06"), "function of the reply is 6, expected 3");
  EXPECT_EQ(fault("01 03 02"), "byte count of the reply is 2, expected 4");
  EXPECT_FALSE(*rtu_answer_size(asked, tests::parse_hex_bytes("01")));
  EXPECT_EQ(rtu_answer_size(asked, tests::parse_hex_bytes("01 03"))->value(), 9u);
}

// The published answers above, among bytes of an idle bus and of other units.
TEST(ModbusRtuFrame, FindsPublishedAnswersAmongNoise) {
  const std::vector<Golden> published{
      {read_of(1, 60, 2), "", "01 03 04 01 90 01 48 FA 44", {400, 328}},
      {write_of(1, 60, 200), "", "01 06 00 3C 00 C8 48 50", {}},
      {read_of(1, 0, 3), "", "01 03 06 01 ED 00 00 00 6C 8C 9E", {493, 0, 108}},
      {read_of(0, 0, 1), "", "00 03 02 08 98 83 EE", {2200}},
      {switch_of(0, 1), "", "00 05 00 01 FF 00 DC 2B", {}},
  };
  const auto other = tests::parse_hex_bytes("07 03 02 00 EC 31 C9");  // another unit
  std::size_t found_again = 0;
  for (const auto& golden : published)
    for (const std::string before : {"", "FF", "00", "FF 00", "01", "01 03", "07 03 02 00 EC 31 C9"})
      for (const std::string after : {"", "00", "FF FF", "07 03 02 00 EC 31 C9"}) {
        const auto bytes = tests::parse_hex_bytes((before + " " + golden.answered + " " + after).c_str());
        const auto start = tests::parse_hex_bytes(before.c_str()).size();
        const auto found = find_rtu_answer(golden.request, bytes);
        ASSERT_TRUE(found.answer) << before << " | " << golden.answered << ": " << found.fault.what;
        EXPECT_EQ(found.answer->words, golden.words);
        EXPECT_EQ(found.begin, start);
        EXPECT_EQ(found.end, start + tests::parse_hex_bytes(golden.answered).size());
        ++found_again;
      }
  EXPECT_EQ(found_again, published.size() * 7 * 4);
  EXPECT_FALSE(find_rtu_answer(read_of(1, 60, 2), other).answer);
}

TEST(ModbusRtuFrame, WaitsForPartialAnswerNotForNoise) {
  const auto asked = read_of(1, 60, 2);
  const auto has_begun = [&](const char* bytes) {
    return find_rtu_answer(asked, tests::parse_hex_bytes(bytes)).has_partial_frame;
  };
  EXPECT_TRUE(has_begun("FF 01 03 04"));
  EXPECT_TRUE(has_begun("01 83 02"));
  EXPECT_FALSE(has_begun("FF"));
  EXPECT_FALSE(has_begun("01 03"));
  EXPECT_FALSE(has_begun("01 03 02 00 EC B9 C9")) << "an answer to another request";
  EXPECT_EQ(find_rtu_answer(asked, tests::parse_hex_bytes("FF 02")).fault.what, "unit of the reply is 255, expected 1");
  EXPECT_EQ(find_rtu_answer(asked, tests::parse_hex_bytes("FF 01 03 04 01 90 01 49 FA 44")).fault.what,
            "the reply has a wrong CRC");
}

TEST(ModbusRtuFrame, DetectsThreeWrongBitsOrBurstOfSixteen) {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  const auto asked = read_of(1, 60, 20);
  const auto good = encode_rtu_reply(asked, Words(20, 0x5A3C));
  for (int round = 0; round < 20'000; ++round) {
    auto bad = good;
    const auto flip = [&](std::size_t bit) { bad[bit / 8] ^= static_cast<std::byte>(1 << bit % 8); };
    if (round % 2 == 0) {
      for (auto flips = 1 + random() % 3; flips > 0; --flips) flip(random() % (8 * bad.size()));
    } else {
      const auto first = random() % (8 * bad.size() - 16);
      for (unsigned bit = 0; bit < 16; ++bit)
        if (bit == 0 || random() % 2 == 0) flip(first + bit);
    }
    if (bad == good) continue;  // two flips cancelled out
    ASSERT_FALSE(decode_rtu_answer(asked, bad)) << "seed " << kSeed << " round " << round;
  }
}

TEST(ModbusRtuServer, TakesFramesFromAStreamOneByOne) {
  const ModbusRequest two{.unit = 1, .function = write_multiple, .address = 5, .count = 2, .words = {1, 2}};
  const auto frame = encode_rtu_request(two);
  for (std::size_t size = 0; size < frame.size(); ++size)
    EXPECT_FALSE(*rtu_request_size(std::span(frame).first(size))) << size;
  EXPECT_EQ(rtu_request_size(frame)->value(), frame.size());
  EXPECT_EQ(rtu_request_size(tests::parse_hex_bytes("01 07 00")).error().kind, FaultKind::corrupted);
}

TEST(ModbusRtuServer, IgnoresWrongCrcAndAnswersWrongRequestByException) {
  auto frame = encode_rtu_request(read_of(1, 0, 1));
  frame.back() ^= std::byte{1};
  EXPECT_EQ(decode_rtu_request(frame).error().kind, FaultKind::corrupted);
  auto none = tests::parse_hex_bytes("01 03 00 00 00 00");
  append_rtu_crc(none);
  EXPECT_EQ(decode_rtu_request(none).error().kind, FaultKind::refused);
  EXPECT_EQ(decode_rtu_request(none).error().what, "3");
}

}  // namespace
}  // namespace gyrotherm::drivers
