// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_format.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/drivers/gyro/virtual_gyro_frame.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

GyroFrame frame(std::uint32_t sequence, std::uint64_t timestamp, std::int64_t pulses, bool good = true) {
  return {.axes = {{.pulses = pulses}}, .sequence = sequence, .timestamp = timestamp, .good = good};
}

std::string hex(const std::vector<std::byte>& bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{:02X}", std::to_integer<int>(byte));
  return text;
}

void expect_same(const GyroFrame* found, const GyroFrame& expected) {
  ASSERT_TRUE(found);
  EXPECT_EQ(found->axes.at(0).pulses, expected.axes.at(0).pulses);
  EXPECT_EQ(found->sequence, expected.sequence);
  EXPECT_EQ(found->timestamp, expected.timestamp);
  EXPECT_EQ(found->good, expected.good);
}

// Generated from the description. The CRC was computed independently (Python's binascii.crc_hqx with 0xFFFF).
TEST(FrameFormat, PinsTheFrameOfTheVirtualGyro) {
  EXPECT_EQ(hex(encode_frame(virtual_gyro_frame(), frame(0x0201, 1'000'000, -2))), "A55A010240420F00FEFFFFFF00003776");
}

TEST(FrameDecoder, ReadsBackWhatWasEncoded) {
  std::mt19937_64 random(3);
  FrameDecoder decoder(virtual_gyro_frame());
  for (int i = 0; i < 1000; ++i) {
    const auto sent =
        frame(random() & 0xFFFF, random() & 0xFFFFFFFF, static_cast<std::int32_t>(random()), random() % 2 == 0);
    decoder.feed(encode_frame(virtual_gyro_frame(), sent));
    expect_same(decoder.take(), sent);
  }
  EXPECT_EQ(decoder.rejected_bytes(), 0u);
}

TEST(FrameDecoder, AcceptsBytesInPieces) {
  FrameDecoder decoder(virtual_gyro_frame());
  const auto bytes = encode_frame(virtual_gyro_frame(), frame(1, 2, 3));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_FALSE(decoder.take());
    decoder.feed(std::span(bytes).subspan(i, 1));
  }
  expect_same(decoder.take(), frame(1, 2, 3));
}

TEST(FrameDecoder, RejectsFrameWithAnyFalseBit) {
  const auto bytes = encode_frame(virtual_gyro_frame(), frame(1, 2, 3));
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    auto falsified = bytes;
    falsified[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    FrameDecoder decoder(virtual_gyro_frame());
    decoder.feed(falsified);
    EXPECT_FALSE(decoder.take()) << bit;
  }
}

TEST(FrameDecoder, FindsTheFrameThatBeginsInsideAFalseOne) {
  FrameDecoder decoder(virtual_gyro_frame());
  decoder.feed(tests::bytes_of("\xA5\x5A noise\xA5"));
  decoder.feed(encode_frame(virtual_gyro_frame(), frame(1, 2, 3)));
  expect_same(decoder.take(), frame(1, 2, 3));
  EXPECT_EQ(decoder.rejected_bytes(), 9u);
}

TEST(FrameFormat, ReadsEveryTypeOrderAndCheck) {
  for (const char* type : {"u8", "u16", "u24", "u32", "i8", "i16", "i24", "i32"})
    for (const char* endian : {"little", "big"})
      for (const char* check : {"none", "sum8", "fletcher8", "fletcher16", "xor8", "crc16", "crc32"}) {
        const auto crc = std::string(check).starts_with("crc") ? "polynomial = 0x1021" : "";
        const auto format =
            frame_format_of(fmt::format("[frame]\nname = \"f\"\nsync = [1]\nlength = 12\n[[frame.field]]\n"
                                        "role = \"increment\"\ntype = \"{}\"\noffset = 2\nendian = \"{}\"\n"
                                        "[frame.check]\nkind = \"{}\"\n{}\n{}\n",
                                        type, endian, check, std::string(check) == "none" ? "" : "offset = 8", crc)
                                .c_str());
        const std::int64_t pulses = type[0] == 'i' ? -100 : 200;
        FrameDecoder decoder(format);
        decoder.feed(encode_frame(format, {.axes = {{.pulses = pulses}}}));
        const auto* frame = decoder.take();
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->axes[0].pulses, pulses) << type << ' ' << endian << ' ' << check;
      }
}

FrameCheck check_of(const std::string& keys) {
  const auto file = TomlTable::parse("[check]\nfrom = 0\n" + keys, "check.toml").value();
  const auto check = read_frame_check(file.table("check"), 5, false);
  const auto verdict = file.verdict();
  EXPECT_TRUE(verdict) << gyrotherm::text(verdict.error());
  return check;
}

// Xsens command that changes to the configuration, and its reply (public driver ethzasl_xsens_driver).
TEST(FrameCheck, NegatedSumMakesAllBytesAddUpToZero) {
  auto check = check_of("kind = \"sum8\"\nnegated = true\noffset = -1\n");
  check.from = 1;
  for (const auto* frame : {"FA FF 30 00 D1", "FA FF 31 00 D0"}) {
    EXPECT_TRUE(has_valid_check(check, tests::from_hex(frame))) << frame;
    auto written = tests::from_hex(frame);
    written.back() = std::byte{0};
    write_check(check, written);
    EXPECT_EQ(written, tests::from_hex(frame));
  }
  EXPECT_FALSE(has_valid_check(check, tests::from_hex("FA FF 30 00 2F"))) << "the sum itself";
  EXPECT_TRUE(has_valid_check(check, tests::from_hex("FA 00 00 00 00")));
}

// Ping of the MicroStrain protocol. The first sum is sent first.
TEST(FrameCheck, Fletcher8SendsFirstSumFirst) {
  const auto check = check_of("kind = \"fletcher8\"\noffset = -2\n");
  EXPECT_TRUE(has_valid_check(check, tests::from_hex("75 65 01 02 02 01 E0 C6")));
  EXPECT_FALSE(has_valid_check(check, tests::from_hex("75 65 01 02 02 01 C6 E0")));
  auto written = tests::from_hex("75 65 01 02 02 01 00 00");
  write_check(check, written);
  EXPECT_EQ(written, tests::from_hex("75 65 01 02 02 01 E0 C6"));
}

std::string mistakes_in(const std::string& text) {
  const auto file = TomlTable::parse(text, "frame.toml").value();
  (void)read_frame_format(file.table("frame"));
  const auto verdict = file.verdict();
  return verdict ? "" : gyrotherm::text(verdict.error());
}

TEST(FrameFormat, ReportsEachError) {
  const std::string head = "[frame]\nname = \"f\"\nsync = [1]\nlength = 8\n";
  const std::string count = "[[frame.field]]\nrole = \"pulse_count\"\ntype = \"i32\"\noffset = 1\n";
  EXPECT_EQ(mistakes_in(head + count), "");
  EXPECT_NE(mistakes_in(head).find("either a field with the role"), std::string::npos);
  EXPECT_NE(mistakes_in(head + count + count).find("2 fields have the role"), std::string::npos);
  EXPECT_NE(mistakes_in(head + "[[frame.field]]\nrole = \"increment\"\ntype = \"i32\"\noffset = 5\n").find("outside"),
            std::string::npos);
  EXPECT_NE(mistakes_in(head + "[[frame.field]]\nrole = \"increment\"\ntype = \"i32\"\noffset = 0\n").find("sync"),
            std::string::npos);
  EXPECT_NE(mistakes_in(head + count + "[frame.check]\nkind = \"crc16\"\noffset = 7\n").find("polynomial"),
            std::string::npos);
  EXPECT_NE(mistakes_in(head + count + "[frame.check]\nkind = \"sum16\"\noffset = 6\nnegated = true\n").find("unknown"),
            std::string::npos);
  EXPECT_NE(mistakes_in(head + count + "colour = 1\n").find("unknown key"), std::string::npos);
  const auto status = [&](const std::string& rule) {
    return mistakes_in(head + count + "[[frame.field]]\nrole = \"status\"\ntype = \"u8\"\noffset = 5\n" +
                       "[[frame.field.rule]]\nmeaning = \"m\"\n" + rule);
  };
  EXPECT_EQ(status("mask = 0x0F\none_of = [1, 4, 15]\n"), "");
  EXPECT_NE(status("mask = 0x0F\none_of = [1, 16]\n").find("does not contain the good value"), std::string::npos);
  EXPECT_NE(status("mask = 0x100\n").find("the mask 0x100 has bits that are never set: the field has 8 bits"),
            std::string::npos);
  EXPECT_NE(status("mask = 0xFFFF\ngood = 3\n").find("the mask 0xffff has bits that are never set"), std::string::npos);
  const auto own_mask = [&](const char* mask) {
    return mistakes_in(head + count + "[[frame.field]]\nrole = \"status\"\ntype = \"u8\"\noffset = 5\nmask = " + mask);
  };
  EXPECT_NE(own_mask("0x101").find("the mask 0x101 has bits that are never set"), std::string::npos);
  EXPECT_EQ(own_mask("0x80"), "");
  EXPECT_NE(status("mask = 0x0F\none_of = [1.5]\n").find("expected values of the status"), std::string::npos);
  EXPECT_NE(status("mask = 0x0F\none_of = [1]\ngood = 1\n").find("unknown key"), std::string::npos);
  EXPECT_NE(mistakes_in("[frame]\nname = \"f\"\nsync = [256]\nlength = 8\n" + count).find("expected bytes"),
            std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::drivers
