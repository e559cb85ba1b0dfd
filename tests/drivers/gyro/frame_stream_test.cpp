// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drivers/gyro/framed_gyro.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

std::vector<std::byte> operator+(std::vector<std::byte> one, const std::vector<std::byte>& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

// Published frames.

constexpr const char* kKvh1775 = "FE81FF55 37A96A6E 38586C1F B75BF862 BF803E78 BB650D28 3B0A37AC 77 3D 0028 4BFA34D8";
constexpr const char* kKvh1750a = "FE81FF55 B606D81E B6C4940F 36D95A83 3C61AD86 3BE5D086 3F7FDCD4 77 72 0026 C0F2D540";
constexpr const char* kKvh1750b = "FE81FF55 B3D0BBE7 32193EF4 30AC19A5 BA8F78D6 3A290594 3F7ECBD4 77 68 001D ADC5F651";
constexpr const char* kKvhInvalid =
    "FE81FF55 3B041F78 B9B96613 BA234B38 BB7C0410 B8DEF480 3F7F4B7B 70 1F 001D F12FB6EE";
constexpr const char* kKvhBadCheck =
    "FE81FF55 B46B86C6 B44F5B83 B4106D09 BB713CB7 BBABD914 3F7E319A 77 69 001D 95BBDB4F";
constexpr const char* kKvhTest = "FE8100AB 7F7F7F7F7F7F377F DA";

struct KvhFrame {
  const char* bytes;
  double gyro[3], acceleration[3];
  std::uint32_t status, sequence;
  double temperature;
};

TEST(GyroStream, DecodesThePublishedFramesOfTheKvhImus) {
  const KvhFrame frames[] = {
      {kKvh1775, {2.0195930e-5, 5.1599109e-5, -1.3111248e-5}, {-1.0019064, -0.0034950468, 0.0021090312}, 0x77, 61, 40},
      {kKvh1750a, {-2.0093353e-6, -5.8584915e-6, 6.4776409e-6}, {0.013774281, 0.0070133833, 0.99946332}, 0x77, 114, 38},
      {kKvh1750b,
       {-9.7199340e-8, 8.9200860e-9, 1.2521936e-9},
       {-0.0010946046, 0.00064476696, 0.99529767},
       0x77,
       104,
       29},
      {kKvhInvalid,
       {0.0020160358, -0.00035362001, -0.00062291650},
       {-0.0038454570, -0.00010631327, 0.99724545},
       0x70,
       31,
       29}};
  const auto format = tests::shipped_stream("kvh-17xx-a").frame;
  const auto near = [](double found, double expected) { EXPECT_NEAR(found, expected, 5e-8 * std::abs(expected)); };
  for (const auto& expected : frames) {
    const tests::DecodedStream fed(format, tests::from_hex(expected.bytes));
    ASSERT_EQ(fed.frames.size(), 1u) << expected.bytes;
    const char* axes[] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i) {
      near(fed.value(std::string("gyro_") + axes[i]), expected.gyro[i]);
      near(fed.value(std::string("acceleration_") + axes[i]), expected.acceleration[i]);
    }
    EXPECT_EQ(fed.frames[0].axes[0].value, fed.value("gyro_z"));
    EXPECT_EQ(fed.value("status"), expected.status);
    EXPECT_EQ(fed.frames[0].sequence, expected.sequence);
    EXPECT_EQ(fed.housekeeping("temperature"), expected.temperature);
    EXPECT_EQ(fed.frames[0].good, expected.status == 0x77);
  }
}

TEST(GyroStream, RejectsThePublishedKvhFrameWithABadCheck) {
  const tests::DecodedStream fed(tests::shipped_stream("kvh-17xx-a").frame,
                                 tests::from_hex(kKvhBadCheck) + tests::from_hex(kKvh1750b));
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_EQ(fed.frames[0].sequence, 104u);
  EXPECT_EQ(fed.rejected, 36u);
}

TEST(GyroStream, SkipsPublishedKvhTestMessage) {
  const tests::DecodedStream fed(tests::shipped_stream("kvh-17xx-a").frame,
                                 tests::from_hex(kKvh1750a) + tests::from_hex(kKvhTest) + tests::from_hex(kKvh1775));
  ASSERT_EQ(fed.frames.size(), 3u);
  EXPECT_EQ(fed.rejected, 0u);
  EXPECT_FALSE(fed.frames[1].axes[0].value);
}

TEST(GyroStream, AnyAxisMayBeTheGyro) {
  for (const auto* axis : {"x", "y", "z"}) {
    const tests::DecodedStream fed(tests::shipped_stream("kvh-17xx-a", {axis}).frame, tests::from_hex(kKvh1775));
    EXPECT_EQ(fed.frames.at(0).axes[0].value, fed.value(std::string("gyro_") + axis));
  }
}

TEST(GyroStream, DecodesThePublishedLineOfTheDsp3000) {
  const tests::DecodedStream fed(tests::shipped_stream("kvh-dsp-3000-ascii").frame,
                                 tests::bytes_of("33   1\r\n       0.015733   1\r\n -1.5 0\r\n"));
  ASSERT_EQ(fed.frames.size(), 2u) << "the first line may have lost its beginning";
  EXPECT_DOUBLE_EQ(fed.frames[0].axes[0].value.value(), 0.015733);
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_DOUBLE_EQ(fed.frames[1].axes[0].value.value(), -1.5);
  EXPECT_FALSE(fed.frames[1].good);
}

constexpr const char* kNovatelLine =
    "%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895"
    "*a5db8c7b\r\n";

TEST(GyroStream, DecodesThePublishedLineOfARingLaserGyro) {
  const struct {
    const char* axis;
    std::int64_t raw;
    double deg_per_h;
  } axes[] = {{"z", -215194, -516.7}, {"y", -41188, 98.9}, {"x", -9895, -23.8}};  // Y is sent negative
  for (const auto& expected : axes) {
    const auto format = tests::shipped_stream("hg1700-rawimusxa", {expected.axis}).frame;
    const tests::DecodedStream fed(format, tests::bytes_of(kNovatelLine));
    ASSERT_EQ(fed.frames.size(), 1u);
    EXPECT_EQ(fed.frames[0].axes[0].pulses, expected.raw);
    const double arcsec = *fed.frames[0].axes[0].value * *arcsec_per(format.gyro()->unit, format.gyro()->role);
    EXPECT_NEAR(arcsec * 100, expected.deg_per_h, 0.05);
    EXPECT_EQ(fed.housekeeping("temperature"), 21.0);
    EXPECT_EQ(fed.frames[0].timestamp, 484620'664'389'000u);
    EXPECT_TRUE(fed.frames[0].good);
  }
}

/// The virtual gyro ends the short header with a semicolon, as a receiver does. The check was computed by zlib's crc32.
TEST(GyroStream, WritesALineOfTheNovatelAsAReceiverDoes) {
  const auto format = tests::shipped_stream("hg1700-rawimusxa").frame;
  const auto bytes =
      encode_frame(format, {.axes = {{.pulses = -215194}}, .timestamp = 484620'664'389'000u, .values = {21}});
  const std::string line(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_EQ(line, "%RAWIMUSXA,0,0;0,1,0,484620.664389000,00001500,0,0,0,-215194,0,0*8033301c\r\n");
}

TEST(GyroStream, AcceptsSemicolonOnlyAfterShortHeader) {
  const auto format = tests::shipped_stream("hg1700-rawimusxa").frame;
  const std::string words =
      "%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895";
  const auto taken = [&](std::string line) {
    const auto check = compute_check_value(format.check, std::as_bytes(std::span(line)).subspan(1));
    return tests::DecodedStream(format, tests::bytes_of(fmt::format("{}*{:08x}\r\n", line, check))).frames.size() == 1;
  };
  EXPECT_TRUE(taken(words));
  auto commas = words;
  std::replace(commas.begin(), commas.end(), ';', ',');
  EXPECT_FALSE(taken(commas));
  for (std::size_t comma = words.find(','); comma != std::string::npos; comma = words.find(',', comma + 1)) {
    auto other = commas;
    other[comma] = ';';
    EXPECT_FALSE(taken(other)) << other;
  }
}

/// Each type of IMU has its own scale in this message.
TEST(GyroStream, AcceptsOnlyRingLaserGyrosBehindReceiver) {
  const auto lines = tests::shipped_stream("hg1700-rawimusxa").frame;
  const auto messages = tests::shipped_stream("hg1700-rawimusx").frame;
  auto message = encode_frame(messages, {});
  for (int type = 0; type < 256; ++type) {
    const bool is_known = type == 1 || type == 4 || type == 11 || type == 12;
    const auto line = fmt::format(
        "%RAWIMUSXA,1692,484620.664;00,{},1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895",
        type);
    const auto check = compute_check_value(lines.check, std::as_bytes(std::span(line)).subspan(1));
    const tests::DecodedStream line_fed(lines, tests::bytes_of(fmt::format("{}*{:08x}\r\n", line, check)));
    EXPECT_EQ(line_fed.frames.size(), is_known ? 1u : 0u) << type;
    message[13] = static_cast<std::byte>(type);
    write_check(messages.check, message);
    EXPECT_EQ(tests::DecodedStream(messages, message).frames.size(), is_known ? 1u : 0u) << type;
  }
}

TEST(GyroStream, RejectsALineWithAnyOtherDigit) {
  const auto format = tests::shipped_stream("hg1700-rawimusxa").frame;
  const std::string line = kNovatelLine;
  for (std::size_t i = 1; i < line.size() - 2; ++i) {
    auto falsified = line;
    falsified[i] = falsified[i] == '7' ? '8' : '7';
    EXPECT_TRUE(tests::DecodedStream(format, tests::bytes_of(falsified)).frames.empty()) << i;
  }
}

// An attitude message in the VN-100 manual. It shows the bytes that the check covers, and its byte order.
TEST(GyroStream, ChecksThePublishedVectorNavMessage) {
  const auto check = tests::shipped_stream("vectornav").frame.check;
  EXPECT_TRUE(has_valid_check(check, tests::from_hex("FA 01 08 00 93502E42 833EF13F 48B504BB 9288")));
  EXPECT_FALSE(has_valid_check(check, tests::from_hex("FA 01 08 00 93502E42 833EF13F 48B504BB 8892")));
}

// Frames without published examples were generated from the instruments' tables by an independent program (Python's
// struct).

constexpr const char* kStim = "94004000FFC000FFFF850014801482F5C0001001F463BD8987";
constexpr const char* kStimOverload = "94004000FFC000FFFF85 10 14801482F5C0001801F4D685788B";

/// Frame of revision B with its check, published by rock-drivers/drivers-imu_stim300 in src/main.cpp.
constexpr const char* kStimRevisionB =
    "97 000137 0001C7 FFFE74 00 000632 0011AD 07F445 00 FFECBC 003793 40062A 00 204F 2069 2055 00 D9 03F8 21C1E045";

TEST(GyroStream, DecodesThePublishedFrameOfTheStim300) {
  const tests::DecodedStream fed(tests::shipped_stream("stim300").frame, tests::from_hex(kStimRevisionB));
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_EQ(fed.frames[0].axes[0].value, -396.0 / 16384);
  EXPECT_EQ(fed.value("gyro_x"), 311.0 / 16384);
  EXPECT_EQ(fed.value("gyro_y"), 455.0 / 16384);
  EXPECT_EQ(fed.housekeeping("acceleration_z"), 521285.0 / 524288);
  EXPECT_EQ(fed.housekeeping("inclination_z"), 4195882.0 / 4194304);
  EXPECT_EQ(fed.housekeeping("temperature_x"), 8271.0 / 256);
  EXPECT_EQ(fed.housekeeping("temperature_z"), 8277.0 / 256);
  EXPECT_EQ(fed.frames[0].sequence, 0xD9u);
  EXPECT_EQ(fed.value("latency_us"), 1016);
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_FALSE(fed.frames[0].flagged);
}

TEST(GyroStream, DecodesGeneratedFramesOfTheStim300) {
  const tests::DecodedStream fed(tests::shipped_stream("stim300").frame,
                                 tests::from_hex(kStim) + tests::bytes_of("\r\n") + tests::from_hex(kStimOverload));
  ASSERT_EQ(fed.frames.size(), 2u);
  EXPECT_EQ(fed.rejected, 0u);
  EXPECT_EQ(fed.value("gyro_x"), 1);
  EXPECT_EQ(fed.value("gyro_y"), -1);
  EXPECT_EQ(fed.frames[0].axes[0].value, -123.0 / 16384);
  EXPECT_EQ(fed.housekeeping("temperature_z"), -10.25);
  EXPECT_EQ(fed.frames[0].sequence, 16u);
  EXPECT_EQ(fed.value("latency_us"), 500);
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_FALSE(fed.frames[1].good);
}

TEST(GyroStream, DecodesGeneratedFramesOfTheHg4930) {
  const tests::DecodedStream fed(
      tests::shipped_stream("hg4930").frame,
      tests::from_hex("0E01640038FF2C01E8030000FFFF02005555145B") +
          tests::from_hex("0E02640038FF2C01E8030000FFFF01005555E803000030F8FFFF711B0D00010000000200000003000000AE73"));
  ASSERT_EQ(fed.frames.size(), 2u);
  EXPECT_FALSE(fed.frames[0].axes[0].value);
  EXPECT_EQ(fed.frames[1].axes[0].pulses, 858993);
  EXPECT_DOUBLE_EQ(fed.frames[1].axes[0].value.value(), 858993.0 / 8589934592.0);
  EXPECT_DOUBLE_EQ(fed.value("rate_z", 1), 300 * 600.0 / 1048576);
  EXPECT_DOUBLE_EQ(fed.value("acceleration_x", 1), 1000 * 600.0 / 16384 * 0.3048);
}

TEST(GyroStream, DecodesAGeneratedFrameOfTheHg1120) {
  const tests::DecodedStream fed(
      tests::shipped_stream("hg1120").frame,
      tests::from_hex("0E050000000000000000000000000000000000000000000007000000F8FFFFFF0900000001000000020000000300"
                      "00001B05"));
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_EQ(fed.frames[0].axes[0].pulses, 9);
}

TEST(GyroStream, DecodesGeneratedFramesOfTheDsp3000) {
  // End of a frame that began earlier.
  std::vector<std::byte> bytes = tests::from_hex("00 39");
  for (int i = 0; i < 60; ++i) bytes = bytes + tests::from_hex(i % 2 == 0 ? "8FFFFFE7" : "8C003039");
  const tests::DecodedStream fed(tests::shipped_stream("kvh-dsp-3000-binary").frame, bytes);
  ASSERT_EQ(fed.frames.size(), 60u);
  EXPECT_EQ(fed.rejected, 2u);
  EXPECT_EQ(fed.frames[0].axes[0].pulses, -25);
  EXPECT_EQ(fed.frames[1].axes[0].pulses, 12345);
  EXPECT_DOUBLE_EQ(fed.frames[1].axes[0].value.value(), 12345 * 6e-6);
  EXPECT_TRUE(fed.frames[1].good);
}

TEST(GyroStream, DecodesGeneratedFramesOfTheDsp1750) {
  const auto frame = [](int count) {
    auto bytes = tests::from_hex(count % 2 == 0 ? "1000003FF7CF" : "100000000008");
    bytes[0] |= static_cast<std::byte>(count % 4 << 6);
    return bytes;
  };
  std::vector<std::byte> bytes = tests::from_hex("00 00 08");
  for (int i = 0; i < 20; ++i) bytes = bytes + frame(i);
  const tests::DecodedStream fed(tests::shipped_stream("kvh-dsp-1750").frame, bytes);
  ASSERT_EQ(fed.frames.size(), 20u);
  EXPECT_EQ(fed.rejected, 3u);
  EXPECT_DOUBLE_EQ(fed.frames[0].axes[0].value.value(), -2097 * 1000.0 / 2097152);
  EXPECT_DOUBLE_EQ(fed.frames[1].axes[0].value.value(), 8 * 1000.0 / 2097152);

  // A missing count drops the lock.
  bytes.erase(bytes.begin() + 3 + 6 * 15, bytes.begin() + 3 + 6 * 16);
  EXPECT_EQ(tests::DecodedStream(tests::shipped_stream("kvh-dsp-1750").frame, bytes).frames.size(), 15u);
}

TEST(GyroStream, DecodesAGeneratedMessageOfTheVectorNav) {
  const tests::DecodedStream fed(
      tests::shipped_stream("vectornav").frame,
      tests::from_hex("FA01010C081A99BE1C0000000000803E000000BF0000003E0000FC410080CA420AD7233C0000003F000080BE0000"
                      "803A0AD7233C0AD7A33C8FC2F53CC3A0"));
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_EQ(fed.frames[0].timestamp, 123456789000u);
  EXPECT_EQ(fed.frames[0].axes[0].value, 0.0009765625);
  EXPECT_EQ(fed.housekeeping("temperature"), 31.5);
  EXPECT_EQ(fed.value("gyro_x"), 0.5);
}

TEST(GyroStream, DecodesGeneratedFramesOfKvhFormatsBAndC) {
  const tests::DecodedStream b(
      tests::shipped_stream("kvh-17xx-b").frame,
      tests::from_hex("FE81FF563727C5ACB7A7C5AC3800000000000000000000003F800000EE6B28007705FFD8CAD73754"));
  ASSERT_EQ(b.frames.size(), 1u);
  EXPECT_EQ(b.frames[0].axes[0].value, 3.0517578125e-05);
  EXPECT_EQ(b.frames[0].timestamp, 4'000'000'000u);
  EXPECT_EQ(b.housekeeping("temperature"), -40.0);
  const tests::DecodedStream c(
      tests::shipped_stream("kvh-17xx-c").frame,
      tests::from_hex("FE81FF573727C5ACB7A7C5AC3800000000000000000000003F80000041BC000077070A95717D"));
  ASSERT_EQ(c.frames.size(), 1u);
  EXPECT_EQ(c.housekeeping("magnetic_z"), 23.5);
  EXPECT_TRUE(std::isnan(c.housekeeping("temperature")));
}

TEST(GyroStream, DecodesGeneratedMessagesOfARingLaserGyro) {
  const tests::DecodedStream fed(
      tests::shipped_stream("hg1700-rawimusx").frame,
      tests::from_hex("AA441304E7039C0601000000010203045EF82C73") +  // another message of the receiver
          tests::from_hex("AA441328B6059C0678B9E21C000B9C060B9755A832941D4103158000EBD09102A687F3FF38EAFCFF66B7FCFF1"
                          "C5FFFFF59D9FFFF475FAFBA"));
  ASSERT_EQ(fed.frames.size(), 2u);
  EXPECT_EQ(fed.rejected, 0u);
  EXPECT_FALSE(fed.frames[0].axes[0].pulses);
  EXPECT_EQ(fed.frames[1].axes[0].pulses, -215194);
  EXPECT_EQ(fed.housekeeping("temperature", 1), 21.0);
  EXPECT_EQ(fed.frames[1].timestamp, 484620'664'389'000u);
}

TEST(GyroStream, DecodesGeneratedIncrementsOfTheStim300) {
  const tests::DecodedStream fed(tests::shipped_stream("stim300-increment").frame,
                                 tests::from_hex("94200000F80000FFFF850014801482F5C0001001F4B2C77C14"));
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_EQ(fed.value("gyro_x"), 1);
  EXPECT_EQ(fed.value("gyro_y"), -0.25);
  EXPECT_EQ(fed.frames[0].axes[0].pulses, -123);
  EXPECT_EQ(fed.housekeeping("temperature_z"), -10.25);
}

/// Recorded acknowledgement and packet of other content, and the packet of the manufacturer's example, whose values are
/// printed beside it (MIP SDK, test/data/mip_data.bin and packet_example_cpp_check.txt).
TEST(GyroStream, DecodesPublishedPacketOfMicroStrain) {
  const tests::DecodedStream fed(
      tests::whole_shipped_stream("microstrain-mip").frame,
      tests::from_hex("7565 01 04 04F10600 DA74") +
          tests::from_hex("7565 80 30 0AD5 00000041D8BAE040 0AD6 00000000007A1200 0E04 3C8EAF72 BBDA6818 BF7C52E8 0E05 "
                          "BB469CCF 39A34C8B BB8BE12F D771") +
          tests::from_hex("7565 80 4C 0AD5 000000055EE67CC0 0AD6 000000014E434A00 0E04 3D9EE88D 387FDB00 BF7AAF03 0E05 "
                          "BB0C1E30 BB572E68 BBAA24AE 0E07 BC8AAC80 BC72C50E BCC4E2C1 0E08 3EEE3D9F BD66DADD C0AFDEF5 "
                          "9196"));
  EXPECT_EQ(fed.rejected, 0u);
  ASSERT_EQ(fed.frames.size(), 3u);
  EXPECT_FALSE(fed.frames[0].axes[0].value);
  EXPECT_FALSE(fed.frames[1].axes[0].value);
  EXPECT_EQ(fed.frames[2].timestamp, 23'067'000'000u);
  EXPECT_EQ(fed.value("delta_time_ns", 2), 5'608'000'000.0);
  EXPECT_NEAR(fed.housekeeping("acceleration_x", 2), 0.077592, 5e-7);
  EXPECT_NEAR(fed.housekeeping("acceleration_y", 2), 0.000061, 5e-7);
  EXPECT_NEAR(fed.housekeeping("acceleration_z", 2), -0.979233, 5e-7);
  EXPECT_NEAR(fed.housekeeping("rate_x", 2), -0.002138, 5e-7);
  EXPECT_NEAR(fed.housekeeping("rate_y", 2), -0.003283, 5e-7);
  EXPECT_NEAR(fed.housekeeping("rate_z", 2), -0.005192, 5e-7);
  EXPECT_NEAR(fed.value("gyro_x", 2), -0.0169279575, 1e-9);
  EXPECT_NEAR(fed.frames[2].axes[2].value.value(), -0.0240339, 1e-7);
}

TEST(GyroStream, DecodesGeneratedPacketOfMicroStrainGeneration5) {
  const tests::DecodedStream fed(
      tests::shipped_stream("microstrain-gx5").frame,
      tests::from_hex(
          "7565 80 46 0E12 411D9432A855970B 069C 001F 0E04 3F000000 BE800000 BF800000 0E05 3A800000 BF000000 "
          "3B800000 0E07 39800000 BE000000 37800000 0E08 00000000 3E800000 BC23D70A 30C2"));
  EXPECT_EQ(fed.rejected, 0u);
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_EQ(fed.frames[0].timestamp, 484620'664'389'000u);
  EXPECT_EQ(fed.frames[0].axes[0].value, 0x1p-16);
  EXPECT_EQ(fed.value("gyro_x"), 0x1p-12);
  EXPECT_EQ(fed.value("gyro_y"), -0.125);
  EXPECT_EQ(fed.housekeeping("rate_z"), 0x1p-8);
  EXPECT_EQ(fed.housekeeping("acceleration_z"), -1);
  EXPECT_EQ(fed.housekeeping("velocity_y"), 0.25);
}

/// The commands were built from the definitions of the SDK; their checks were computed independently.
TEST(GyroStream, StartsMicroStrainWithValidPackets) {
  for (const auto* name : {"microstrain-mip", "microstrain-gx5"}) {
    const auto stream = tests::shipped_stream(name);
    ASSERT_EQ(stream.start.size(), 4u);
    for (const auto& command : stream.start)
      EXPECT_TRUE(has_valid_check(stream.frame.check, tests::bytes_of(command.send))) << command_name(command);
  }
}

/// Recorded message with other items (einride/xsens-go, testdata/1) and acknowledgement, then generated messages. In
/// the second generated message, the range of gyro Z is exceeded.
TEST(GyroStream, DecodesMessagesOfXsens) {
  const tests::DecodedStream fed(
      tests::shipped_stream("xsens-mti").frame,
      tests::from_hex("FA FF 31 00 D0") +
          tests::from_hex(
              "FAFF3671102002A9871060040314EDB710100C07DCA26007E301140D2F1837E020040000000520300CC2C6EC743E0"
              "83F53C33330CB40200C3CE7E9CBC11A8E2FBFD04D0C40100C39931323BDC5D49BBC8552C480200C3AB21F42BB513AB"
              "9BB51E94C8030103F80000136E3FF0CB785E822B78657DF19") +
          tests::from_hex(
              "FAFF3638102002FFFE1060040314ED53E0200400000107081004C144000040200C3F000000BE800000411D00008020"
              "0C3A800000BF0000003780000049") +
          tests::from_hex(
              "FAFF3638102002FFFE1060040314ED53E0200400002007081004C144000040200C3F000000BE800000411D00008020"
              "0C3A800000BF000000378000002A"));
  EXPECT_EQ(fed.rejected, 0u);
  ASSERT_EQ(fed.frames.size(), 4u);
  EXPECT_FALSE(fed.frames[1].axes[0].value);
  EXPECT_EQ(fed.frames[2].axes[0].value, 0x1p-16);
  EXPECT_EQ(fed.value("gyro_x", 2), 0x1p-10);
  EXPECT_EQ(fed.value("gyro_y", 2), -0.5);
  EXPECT_EQ(fed.housekeeping("acceleration_z", 2), 9.8125);
  EXPECT_EQ(fed.housekeeping("temperature", 2), -12.25);
  EXPECT_EQ(fed.frames[2].sequence, 0xFFFEu);
  EXPECT_EQ(fed.frames[2].timestamp, 51'703'123u) << "in steps of 0.1 ms";
  EXPECT_TRUE(fed.frames[2].good);
  EXPECT_TRUE(fed.frames[2].flagged) << "the range of an accelerometer was exceeded";
  EXPECT_FALSE(fed.frames[3].good);
}

TEST(GyroStream, RejectsMessageOfOtherItemsWithSameLength) {
  for (const auto& [name, offset] : {std::pair("xsens-mti", 45u), {"microstrain-mip", 53u}, {"microstrain-gx5", 47u}}) {
    const auto format = tests::shipped_stream(name).frame;
    auto message = encode_frame(format, {.axes = {{.value = 0.5}}});
    EXPECT_EQ(tests::DecodedStream(format, message).frames.size(), 1u) << name;
    message[offset] ^= std::byte{0x10};
    write_check(format.check, message);
    EXPECT_TRUE(tests::DecodedStream(format, message).frames.empty()) << name;
  }
}

TEST(GyroStream, RequestsConfigurationOfXsensWithValidMessages) {
  const auto stream = tests::shipped_stream("xsens-mti");
  ASSERT_EQ(stream.start.size(), 3u);
  for (const auto& command : stream.start) {
    EXPECT_TRUE(has_valid_check(stream.frame.check, tests::bytes_of(command.send))) << command_name(command);
    EXPECT_TRUE(has_valid_check(stream.frame.check, tests::bytes_of(command.reply))) << command_name(command);
  }
}

TEST(GyroStream, DecodesGeneratedMessagesOfSbg) {
  const auto other = tests::from_hex("FF5A01000400010203045C5433");
  const tests::DecodedStream brief(
      tests::shipped_stream("sbg-imu-short").frame,
      other + tests::from_hex("FF5A2C00200000286BEEFF03000010000000F8FF3DEA9C0024060100000000FEFBFFFFFFC0F5B59433") +
          tests::from_hex("FF5A2C002000883B6BEEFF070000000000000000000000000100000002000000030000000000F3AE33"));
  EXPECT_EQ(brief.rejected, 0u);
  ASSERT_EQ(brief.frames.size(), 3u);
  EXPECT_FALSE(brief.frames[0].axes[0].value);
  EXPECT_EQ(brief.frames[1].axes[0].value, -5 * 0x1p-26);
  EXPECT_EQ(brief.value("gyro_x", 1), 67108 * 0x1p-26);
  EXPECT_EQ(brief.value("gyro_y", 1), -0.5);
  EXPECT_EQ(brief.housekeeping("acceleration_x", 1), 1);
  EXPECT_EQ(brief.housekeeping("acceleration_y", 1), -524288 * 0x1p-20);
  EXPECT_EQ(brief.housekeeping("temperature", 1), -10.25);
  EXPECT_EQ(brief.frames[1].timestamp, 4'000'000'000u);
  EXPECT_TRUE(brief.frames[1].good);
  EXPECT_FALSE(brief.frames[2].good) << "the scale of the high range";

  const tests::DecodedStream full(
      tests::shipped_stream("sbg-imu-data").frame,
      other + tests::from_hex("FF5A03003A0000286BEEEF030000003F000080BE00001D410000803A000000BF00008037000022C20000003F"
                              "000080BE00001D410000803A000000BF00008037882C33"));
  EXPECT_EQ(full.rejected, 0u);
  ASSERT_EQ(full.frames.size(), 2u);
  EXPECT_EQ(full.frames[1].axes[0].value, 0x1p-16);
  EXPECT_EQ(full.value("gyro_x", 1), 0x1p-10);
  EXPECT_EQ(full.housekeeping("acceleration_z", 1), 9.8125);
  EXPECT_EQ(full.housekeeping("temperature", 1), -40.5);
  EXPECT_TRUE(full.frames[1].good);
  EXPECT_TRUE(full.frames[1].flagged) << "accelerometer Z failed its test or is out of range";
}

/// The first frame has the values and the checksum of a published log line (py_esensorlib, README.md) of an M-G366PDG0,
/// whose scales are 1/66 °/s, 1/4 mg and 1/256 °C. The temperature has the digits that agree with the checksum.
TEST(GyroStream, DecodesPublishedLogLineOfEpson) {
  const tests::DecodedStream fed(
      tests::shipped_stream("epson-m-g370pds0").frame,
      tests::from_hex("80 FEFC FFF6FA00 000B4329 FFFCF746 FFFFE1B3 00084EE0 00175CA4 FD60083C 0014 C66D 0D"));
  ASSERT_EQ(fed.frames.size(), 1u);
  EXPECT_NEAR(fed.value("gyro_x") * 150 / 66, 0.17064158, 1e-8);
  EXPECT_NEAR(fed.value("gyro_y") * 150 / 66, -0.04597103, 1e-8);
  EXPECT_NEAR(fed.value("gyro_z") * 150 / 66, -0.00179337, 1e-8);
  EXPECT_NEAR(fed.housekeeping("acceleration_x") * 2500 / 4, 2.07702637, 1e-8);
  EXPECT_NEAR(fed.housekeeping("acceleration_z") * 2500 / 4, -167.99195862, 1e-8);
  EXPECT_EQ(fed.frames[0].sequence, 20u);
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_FALSE(fed.frames[0].flagged);
}

TEST(GyroStream, DecodesGeneratedFramesOfEpson) {
  const tests::DecodedStream fed(
      tests::shipped_stream("epson-m-g370pds0").frame,
      tests::from_hex("80FE000662000000960000FFB50000FFFFFFF904E20000FFE7000009C40000FFF013220D") +
          tests::from_hex("80FE01000000000000000000000000000000000000000000000000000000000000FE010D"));
  EXPECT_EQ(fed.rejected, 0u);
  ASSERT_EQ(fed.frames.size(), 2u);
  EXPECT_DOUBLE_EQ(fed.value("gyro_x"), 1);
  EXPECT_DOUBLE_EQ(fed.value("gyro_y"), -0.5);
  EXPECT_DOUBLE_EQ(fed.frames[0].axes[0].value.value(), -7.0 / 150 / 65536);
  EXPECT_DOUBLE_EQ(fed.housekeeping("acceleration_x"), 0.5);
  EXPECT_DOUBLE_EQ(fed.housekeeping("acceleration_z"), 1);
  EXPECT_NEAR(fed.housekeeping("temperature"), 25 + 3.7918, 1e-9);
  EXPECT_EQ(fed.frames[0].sequence, 0xFFF0u);
  EXPECT_TRUE(fed.frames[0].good);
  EXPECT_FALSE(fed.frames[1].good);
}

TEST(GyroStream, EveryShippedDescriptionReadsBackWhatItEncodes) {
  const auto names = tests::shipped_streams();
  EXPECT_EQ(names.size(), 21u);
  for (const auto& name : names) {
    const auto stream = tests::shipped_stream(name);
    EXPECT_FALSE(stream.source.empty());
    std::vector<std::byte> bytes = stream.frame.line ? tests::bytes_of("\r\n") : std::vector<std::byte>();
    constexpr std::size_t kFrames = 200;
    const auto* sequence = stream.frame.find(FieldRole::sequence);
    for (std::size_t i = 0; i < kFrames; ++i) {
      const auto count = sequence ? i * sequence->step % sequence->range : i;
      const double value = (static_cast<double>(i) - 100) / 1024;
      const auto pulses = static_cast<std::int64_t>(i) - 100;
      const auto exact = is_real(stream.frame.gyro()->type) ? std::nullopt : std::optional(pulses);
      const GyroFrame frame{.axes = {{.pulses = exact, .value = value}},
                            .sequence = static_cast<std::uint32_t>(count),
                            .timestamp = 1'000'000 * i,
                            .good = i % 3 != 0};
      bytes = bytes + encode_frame(stream.frame, frame) + stream.frame.tail;
    }
    const tests::DecodedStream fed(stream.frame, bytes);
    ASSERT_EQ(fed.frames.size(), kFrames) << name;
    for (std::size_t i = 0; i < kFrames; ++i) {
      if (is_real(stream.frame.gyro()->type))
        EXPECT_NEAR(fed.frames[i].axes[0].value.value(), (static_cast<double>(i) - 100) / 1024, 1e-9) << name;
      else
        EXPECT_EQ(fed.frames[i].axes[0].pulses, static_cast<std::int64_t>(i) - 100) << name;
    }
  }
}

TEST(GyroStream, ReportsEachErrorOfHeader) {
  const auto mistake = [](const std::string& was, const std::string& is) {
    auto changed = tests::shipped_stream("hg1700-rawimusxa").text;
    changed.replace(changed.find(was), was.size(), is);
    const auto stream = parse_gyro_stream(changed, "g.toml");
    return stream ? std::string() : text(stream.error());
  };
  EXPECT_NE(mistake("header_end = \";\"", "header_end = \",\"").find("separator"), std::string::npos);
  EXPECT_NE(mistake("header_end = \";\"", "").find("missing key \"header_end\""), std::string::npos);
  EXPECT_NE(mistake("header_words = 3", "").find("missing key \"header_words\""), std::string::npos);
  EXPECT_NE(mistake("header_words = 3", "header_words = 14").find("fewer than \"words\""), std::string::npos);
}

TEST(GyroStream, ReportsEachError) {
  const std::string good = tests::shipped_stream("kvh-17xx-a").text;
  const auto mistake = [&](const std::string& was, const std::string& is) {
    auto changed = good;
    const auto place = changed.find(was);
    if (place == std::string::npos) return "no \"" + was + "\" in the file";
    changed.replace(place, was.size(), is);
    const auto stream = parse_gyro_stream(changed, "g.toml");
    return stream ? std::string() : text(stream.error());
  };
  EXPECT_EQ(mistake("axis = \"z\"", "axis = \"x\""), "");
  EXPECT_NE(mistake("axis = \"z\"", "axis = \"w\"").find("no gyro field has the axis \"w\""), std::string::npos);
  EXPECT_NE(mistake("unit = \"rad\"", "unit = \"furlong\"").find("expected \"rad\""), std::string::npos);
  EXPECT_NE(mistake("length = 36", "length = 30").find("outside the frame"), std::string::npos);
  EXPECT_NE(mistake("offset = -4", "offset = -3").find("check lies outside"), std::string::npos);
  EXPECT_NE(mistake("ids = [0xFF55]", "ids = [0xFF59]").find("no message has the id"), std::string::npos);
  EXPECT_NE(mistake("modulus = 128", "modulus = 1").find("whole number from 2"), std::string::npos);
  EXPECT_NE(mistake("baud = 921600", "baud = 1").find("baud"), std::string::npos);
  EXPECT_NE(mistake("confidence = \"verified\"", "confidence = \"sure\"").find("sure"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::drivers
