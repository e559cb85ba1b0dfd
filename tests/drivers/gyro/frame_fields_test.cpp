// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_fields.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "drivers/gyro/frame_format.hpp"
#include "tests/drivers/gyro/decimal_lines.hpp"
#include "tests/drivers/gyro/virtual_gyro_frame.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

/// Returns the only field of a frame of eleven bytes that begins with 01.
FrameField field_of(const std::string& keys, const std::string& role = "value") {
  const auto text = fmt::format(
      "[frame]\nname = \"f\"\nsync = [1]\nlength = 11\n[[frame.field]]\nrole = \"{}\"\noffset = 2\n{}\n"
      "[[frame.field]]\nrole = \"increment\"\ntype = \"u8\"\noffset = 1\n",
      role, keys);
  return frame_format_of(text.c_str()).fields.front();
}

double value_of(const FrameField& field, const char* bytes) {
  return apply_scale(field, read_raw(field, tests::from_hex(bytes)).value());
}

TEST(FrameField, ReadsEveryTypeInBothOrders) {
  const char* frame = "01 00 41 20 00 00 00 00 00 FE 00";
  EXPECT_EQ(value_of(field_of("type = \"f32\"\nendian = \"big\""), frame), 10);
  EXPECT_EQ(value_of(field_of("type = \"f64\"\nendian = \"big\""), frame), 0x1p+19 + 0xFEp-33);
  EXPECT_EQ(value_of(field_of("type = \"u16\""), frame), 0x2041);
  EXPECT_EQ(value_of(field_of("type = \"u24\"\nendian = \"big\""), frame), 0x412000);
  EXPECT_EQ(value_of(field_of("type = \"i64\""), frame), -0x1p+57 + 0x2041);
  EXPECT_EQ(value_of(field_of("type = \"u64\""), frame), 0xFEp+56 + 0x2041);
}

TEST(FrameField, ReadsSlicesWithTheirSign) {
  EXPECT_EQ(value_of(field_of("type = \"i32\"\nendian = \"big\"\nbits = 26"), "01 00 8F FF FF E7 0000000000"), -25);
  EXPECT_EQ(value_of(field_of("type = \"u8\"\nbit = 6\nbits = 2"), "01 00 9F 0000000000000000"), 2);
  EXPECT_EQ(value_of(field_of("type = \"i8\"\nbit = 6\nbits = 2"), "01 00 9F 0000000000000000"), -2);
}

TEST(FrameField, ReadsSevenBitsOfAByte) {
  const std::string four = "type = \"i32\"\nbytes = 4\nbits_per_byte = 7\nbits = 28\n";
  EXPECT_EQ(value_of(field_of(four + "endian = \"big\""), "01 00 00 00 01 00 0000000000"), 128);
  EXPECT_EQ(value_of(field_of(four + "endian = \"big\""), "01 00 7F 7F 7F 7E 0000000000"), -2);
  EXPECT_EQ(value_of(field_of("type = \"i32\"\nbytes = 5\nbits_per_byte = 7"), "01 00 7E 7F 7F 7F 0F 00000000"), -2);
}

TEST(FrameField, ScalesExactly) {
  const auto field =
      field_of("type = \"i16\"\nscale = { numerator = 5, denominator = 9, power_of_two = -1 }\nzero = -17");
  EXPECT_DOUBLE_EQ(value_of(field, "01 00 12 00 00000000000000"), 18 * 5.0 / 9 / 2 - 17);
}

TEST(FrameField, WritesOnlyItsBits) {
  const std::uint64_t seed = 11;
  std::mt19937_64 random(seed);
  for (int i = 0; i < 2000; ++i) {
    const auto low = static_cast<unsigned>(random() % 20), bits = static_cast<unsigned>(1 + random() % (32 - low));
    const auto field = field_of(fmt::format("type = \"{}\"\nendian = \"{}\"\nbit = {}\nbits = {}",
                                            random() % 2 ? "i32" : "u32", random() % 2 ? "big" : "little", low, bits));
    std::vector<std::byte> frame(11);
    for (auto& byte : frame) byte = static_cast<std::byte>(random());
    const auto before = frame;
    const auto raw = read_raw(field, frame).value();
    write_raw(field, frame, {.whole = static_cast<std::int64_t>(random())});
    write_raw(field, frame, raw);
    EXPECT_EQ(frame, before) << "seed " << seed << ", turn " << i;
  }
}

TEST(FrameField, RejectsIncompleteTokens) {
  FrameField field{.type = FieldType::decimal};
  EXPECT_EQ(parse_token(field, "-1.5e-3").value().real, -1.5e-3);
  EXPECT_EQ(parse_token(field, "+2").value().real, 2);
  for (const char* bad : {"", "+", "1.5x", "--1", "+-1", " 1", "1e999"}) EXPECT_FALSE(parse_token(field, bad)) << bad;
  field = {.type = FieldType::signed_hexadecimal, .low_bit = 8, .bits = 8};
  EXPECT_EQ(parse_token(field, "0080EC03").value().whole, -20);
  EXPECT_FALSE(parse_token(field, "0080ECG3"));
}

TEST(FrameField, TakesSliceOfDecimalWord) {
  const FrameField middle{.type = FieldType::integer, .low_bit = 4, .bits = 8};
  EXPECT_EQ(parse_token(middle, "2035").value().whole, 0x7F);
  EXPECT_EQ(parse_token(middle, "4080").value().whole, -1) << "the sign is that of the slice";
  const FrameField counter{.type = FieldType::integer, .bits = 16};
  for (const auto* number : {"0", "32767", "32768", "40000", "65535"})
    EXPECT_EQ(sequence_number(counter, parse_token(counter, number).value()), std::stoul(number));
}

/// Slices of one decimal word are combined, as the decoder takes them apart.
TEST(FrameField, WritesSlicesOfDecimalWord) {
  const auto format = decimal_lines(R"([[frame.field]]
role = "sequence"
word = 2
type = "integer"
bit = 4
bits = 16
[[frame.field]]
role = "status"
word = 2
type = "integer"
bit = 0
bits = 1
good = 0
)");
  for (const std::uint32_t sequence : {5u, 32768u, 65535u})
    for (const bool good : {true, false}) {
      const auto line = encode_frame(format, {.axes = {{.value = 1.0}}, .sequence = sequence, .good = good});
      FrameDecoder decoder(format);
      decoder.feed(line);
      decoder.feed(line);
      const auto* frame = decoder.take();
      ASSERT_TRUE(frame) << sequence;
      EXPECT_EQ(frame->sequence, sequence);
      EXPECT_EQ(frame->good, good);
    }
}

FrameCheck check_of(const std::string& keys) {
  const auto text =
      "[frame]\nname = \"f\"\nsync = [1]\nlength = 11\n[[frame.field]]\nrole = \"increment\"\ntype = "
      "\"u8\"\noffset = 1\n[frame.check]\n" +
      keys;
  return frame_format_of(text.c_str()).check;
}

TEST(FrameCheck, WritesValidCheck) {
  const char* kinds[] = {"kind = \"sum8\"\noffset = -1",
                         "kind = \"sum16\"\noffset = -3\nendian = \"big\"",
                         "kind = \"xor8\"\nfrom = 1\noffset = 10",
                         "kind = \"crc\"\nwidth = 8\npolynomial = 7\noffset = 2\nfrom = 3\nto = 11",
                         "kind = \"crc\"\nwidth = 24\npolynomial = 0x864CFB\ninitial = 0xB704CE\noffset = -3",
                         "kind = \"crc32\"\npolynomial = 0x04C11DB7\npadded_to = 4\noffset = -4",
                         "kind = \"odd_parity\"\noffset = 3\nbit = 5",
                         "kind = \"even_parity\"\noffset = 3\nbit = 5\nto = 9"};
  const std::uint64_t seed = 13;
  std::mt19937_64 random(seed);
  for (const auto* kind : kinds) {
    const auto check = check_of(kind);
    for (int i = 0; i < 100; ++i) {
      std::vector<std::byte> frame(11);
      for (auto& byte : frame) byte = static_cast<std::byte>(random());
      write_check(check, frame);
      ASSERT_TRUE(has_valid_check(check, frame)) << kind << ", seed " << seed;
      frame[4] ^= std::byte{0x10};
      EXPECT_FALSE(has_valid_check(check, frame)) << kind << ", seed " << seed;
    }
  }
}

// Check values of "123456789" from the catalogue of parametrised CRC algorithms.
TEST(FrameCheck, AgreesWithThePublishedValuesOfOtherWidths) {
  const auto digits = tests::bytes_of("123456789");
  EXPECT_EQ(crc({8, 0x07, 0, false, 0}, digits), 0xF4u) << "CRC-8/SMBUS";
  EXPECT_EQ(crc({24, 0x864CFB, 0xB704CE, false, 0}, digits), 0x21CF02u) << "CRC-24/OPENPGP";
  EXPECT_EQ(crc({5, 0x05, 0x1F, true, 0x1F}, digits), 0x19u) << "CRC-5/USB";
  EXPECT_EQ(crc({12, 0x80F, 0, false, 0, true}, digits), 0xDAFu) << "CRC-12/UMTS, mirrored out alone";
}

TEST(FrameFormat, RejectsFrameWithReservedBits) {
  auto frame = tests::from_hex("FE81FF55 37A96A6E 38586C1F B75BF862 BF803E78 BB650D28 3B0A37AC 77 3D 0028 4BFA34D8");
  const auto format = tests::shipped_stream("kvh-17xx-a").frame;
  frame[28] = std::byte{0x7F};
  write_check(format.check, frame);
  EXPECT_TRUE(tests::DecodedStream(format, frame).frames.empty());
  frame[28] = std::byte{0x37};
  write_check(format.check, frame);
  const tests::DecodedStream fed(format, frame);
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_EQ(fed.broken_rules[0], std::vector<std::string>{"an accelerometer is invalid"});
}

}  // namespace
}  // namespace gyrotherm::drivers
