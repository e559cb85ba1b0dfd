// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>

#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "tests/support/hex_bytes.hpp"

namespace gyrotherm::drivers {
namespace {

std::string sent(const MccRequest& request) { return tests::format_hex(encode_mcc_request(request)); }

// Bytes sent by the vendor's library.
TEST(MccUsbTempCodec, AsksAsTheVendorsLibraryDoes) {
  EXPECT_EQ(sent(mcc_read_calibration_date()), "30 F0 00 00 06");
  for (std::uint8_t input = 0; input < kMccInputs; ++input)
    EXPECT_EQ(sent(mcc_read_input(input)), fmt::format("18 {:02X} 00", input));
  EXPECT_EQ(sent(mcc_read_input(kMccColdJunction0)), "18 80 00");
  EXPECT_EQ(sent(mcc_scan(0, 7)), "19 00 07 00");
  EXPECT_EQ(sent(mcc_scan(0, 3)), "19 00 03 00");
  EXPECT_EQ(sent(mcc_set_item(2, MccItem::thermocouple, std::uint8_t{2})), "49 01 10 02");
  EXPECT_EQ(sent(mcc_read_item(2, MccItem::thermocouple)), "4A 01 10");
  EXPECT_EQ(sent(mcc_read_item(2, MccItem::sensor)), "4A 01 00");
}

TEST(MccUsbTempCodec, AddressesItemOfOddInputAsNextOne) {
  EXPECT_EQ(sent(mcc_read_item(3, MccItem::thermocouple)), "4A 01 11");
  EXPECT_EQ(sent(mcc_read_item(7, MccItem::coefficient_3)), "4A 03 1B");
  EXPECT_EQ(sent(mcc_read_item(3, MccItem::filter)), "4A 01 02");
}

TEST(MccUsbTempCodec, ScansEightTemperatures) {
  const auto report =
      tests::parse_hex_bytes("19 0000A141 0000A941 0000B141 0000B941 0000C141 00E00AC6 0000D141 0000D941");
  const auto readings = decode_mcc_temperatures(mcc_scan(0, 7), report).value();
  ASSERT_EQ(readings.size(), kMccInputs);
  for (std::size_t i = 0; i < kMccInputs; ++i)
    if (i != 5) {
      EXPECT_EQ(readings[i].value(), Celsius{20.125 + static_cast<double>(i)});
    }
  EXPECT_EQ(readings[5].error().kind, FaultKind::out_of_range);
  EXPECT_EQ(text(readings[5].error()), "input 5: open thermocouple (-8888)");
}

TEST(MccUsbTempCodec, ReadsOneInput) {
  const auto three = decode_mcc_temperatures(mcc_read_input(3), tests::parse_hex_bytes("18 0000B941")).value();
  ASSERT_EQ(three.size(), 1u);
  EXPECT_EQ(three[0].value(), Celsius{23.125});
  const auto five = decode_mcc_temperatures(mcc_read_input(5), tests::parse_hex_bytes("18 00E00AC6")).value();
  EXPECT_EQ(five[0].error().where, "input 5");
  const auto junction =
      decode_mcc_temperatures(mcc_read_input(kMccColdJunction1), tests::parse_hex_bytes("18 00A00CC6")).value();
  EXPECT_EQ(junction[0].error().where, "CJC1");
}

TEST(MccUsbTempCodec, SpecialValuesAreNotTemperatures) {
  for (const auto& [bytes, meaning] : {std::pair{"00 E0 0A C6", "open thermocouple (-8888)"},
                                       {"00 A0 0C C6", "not ready (-9000)"},
                                       {"00 3C 1C C6", "disabled, or floating-point error (-9999)"}}) {
    const auto report = tests::parse_hex_bytes(std::string("18 ") + bytes);
    EXPECT_EQ(decode_mcc_temperatures(mcc_read_input(0), report).value()[0].error().what, meaning);
    const auto numbers = decode_mcc_numbers(mcc_read_input(0), report).value();
    EXPECT_EQ(encode_mcc_numbers(MccCommand::read_input, numbers), report);
  }
  // The special values are compared as whole numbers.
  const std::array almost{-8888.25f};
  const auto report = encode_mcc_numbers(MccCommand::read_input, almost);
  EXPECT_EQ(decode_mcc_temperatures(mcc_read_input(0), report).value()[0].error().what, "open thermocouple (-8888.25)");
}

TEST(MccUsbTempCodec, ReportsFaultOfReadingOutsideSensorRange) {
  MccRanges ranges = mcc_max_ranges();
  ranges[1] = mcc_range(MccThermocouple{MccThermocoupleType::t});
  const std::array numbers{401.f, 401.f, -271.f, std::numeric_limits<float>::quiet_NaN(), 1e30f, -274.f};
  const auto report = encode_mcc_numbers(MccCommand::scan, numbers);
  const auto readings = decode_mcc_temperatures(mcc_scan(0, 5), report, ranges).value();
  EXPECT_TRUE(readings[0]);
  EXPECT_EQ(readings[1].error().where, "input 1");
  EXPECT_TRUE(readings[2]);
  for (const auto input : {3, 4, 5}) EXPECT_EQ(readings[input].error().kind, FaultKind::out_of_range) << input;
}

TEST(MccUsbTempCodec, NamesInputsOfScanThatStartsLater) {
  const std::array numbers{20.f, kMccOpen};
  const auto readings = decode_mcc_temperatures(mcc_scan(6, 7), encode_mcc_numbers(MccCommand::scan, numbers)).value();
  EXPECT_EQ(readings[1].error().where, "input 7");
}

TEST(MccUsbTempCodec, ReadsTheCalibrationDate) {
  using std::chrono::year;
  const auto bytes =
      decode_mcc_bytes(mcc_read_calibration_date(), tests::parse_hex_bytes("30 18 05 11 0A 1E 00")).value();
  const std::chrono::local_days day{year(2024) / 5 / 17};
  EXPECT_EQ(decode_mcc_date(bytes).value(), day + std::chrono::hours(10) + std::chrono::minutes(30));
}

TEST(MccUsbTempCodec, RejectsInvalidTime) {
  using Bytes = std::vector<std::uint8_t>;
  for (const auto& wrong : {Bytes{}, Bytes{24, 5, 17, 10, 30}, Bytes{24, 2, 30, 0, 0, 0}, Bytes{24, 13, 1, 0, 0, 0},
                            Bytes{24, 5, 0, 0, 0, 0}, Bytes{24, 5, 17, 24, 0, 0}, Bytes{24, 5, 17, 0, 60, 0},
                            Bytes{255, 255, 255, 255, 255, 255}})
    EXPECT_EQ(decode_mcc_date(wrong).error().kind, FaultKind::corrupted);
}

TEST(MccUsbTempCodec, SetsAndReadsANumber) {
  EXPECT_EQ(sent(mcc_set_item(2, MccItem::coefficient_0, 100.02f)), "49 01 14 3D 0A C8 42");
  const auto query = mcc_read_item(2, MccItem::coefficient_0);
  EXPECT_EQ(sent(query), "4A 01 14");
  EXPECT_EQ(decode_mcc_numbers(query, tests::parse_hex_bytes("4A 3D0AC842")).value(), std::vector{100.02f});
  EXPECT_EQ(decode_mcc_bytes(mcc_read_item(2, MccItem::thermocouple), tests::parse_hex_bytes("4A 02")).value(),
            std::vector<std::uint8_t>{2});
}

TEST(MccUsbTempCodec, DetectsEndOfCalibration) {
  const auto query = mcc_request(MccCommand::read_status);
  EXPECT_TRUE(is_mcc_calibrating(decode_mcc_bytes(query, tests::parse_hex_bytes("44 01")).value()[0]));
  EXPECT_FALSE(is_mcc_calibrating(decode_mcc_bytes(query, tests::parse_hex_bytes("44 00")).value()[0]));
}

TEST(MccUsbTempCodec, AnotherCommandsReportIsCorrupted) {
  for (const char* wrong : {"", "18 0000B941", "19", "19 0000B9", "19 0000B941 0000B9"})
    EXPECT_EQ(decode_mcc_temperatures(mcc_scan(0, 1), tests::parse_hex_bytes(wrong)).error().kind, FaultKind::corrupted)
        << wrong;
  EXPECT_EQ(decode_mcc_temperatures(mcc_scan(0, 1), tests::parse_hex_bytes("18 0000B941 0000B941")).error().what,
            "unexpected report 18");
}

TEST(MccUsbTempCodec, PaddingIsNotContents) {
  auto report = tests::parse_hex_bytes("18 0000B941");
  report.resize(kMccLongestReport);
  EXPECT_EQ(decode_mcc_temperatures(mcc_read_input(3), report).value()[0].value(), Celsius{23.125});
  EXPECT_EQ(decode_mcc_request(tests::parse_hex_bytes("44 00")).value(), mcc_request(MccCommand::read_status));
  report.resize(kMccLongestReport + 1);
  EXPECT_FALSE(decode_mcc_temperatures(mcc_read_input(3), report));
}

TEST(MccUsbTempCodec, MemoryAndFirmwareAreNeverWritten) {
  for (const char* report : {"31 F0 00 06 18 05 11 0A 1E 00", "50", "51 00", "53 00", "55 00"})
    EXPECT_EQ(decode_mcc_request(tests::parse_hex_bytes(report)).error().kind, FaultKind::corrupted) << report;
}

TEST(MccUsbTempCodec, RefusesUnsupportedArguments) {
  for (const char* report : {"18 08 00", "18 82 00", "18 00 02", "19 00 08 00", "19 03 02 00", "19 00 07 02",
                             "30 00 00 00 00", "30 00 00 00 3F", "30 00 00 01 3D", "30 00 00 02 01", "30 F0 00 00 11",
                             "30 00 01 00 01", "49 04 00 00", "49 00 0B 00", "4A 00 1C", "4A 00 0F"})
    EXPECT_EQ(decode_mcc_request(tests::parse_hex_bytes(report)).error().kind, FaultKind::refused) << report;
}

TEST(MccUsbTempCodec, WhatEncodesDecodesToTheSame) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 1000; ++round) {
    const auto first = static_cast<std::uint8_t>(random() % kMccInputs);
    const auto last = static_cast<std::uint8_t>(first + random() % (kMccInputs - first));
    const auto scan = mcc_scan(first, last);
    EXPECT_EQ(decode_mcc_request(encode_mcc_request(scan)).value(), scan) << "seed " << kSeed << " round " << round;
    std::vector<float> numbers;
    for (int i = first; i <= last; ++i) numbers.push_back(static_cast<float>(random() % 100000) / 128 - 200);
    const auto report = encode_mcc_numbers(MccCommand::scan, numbers);
    EXPECT_EQ(report.size(), 1 + mcc_reply_length(scan));
    EXPECT_EQ(decode_mcc_numbers(scan, report).value(), numbers) << "seed " << kSeed << " round " << round;
  }
}

TEST(MccUsbTempSetup, DescribesThermocoupleWithoutExcitation) {
  std::string all;
  for (const auto& request : mcc_setup(3, MccThermocouple{MccThermocoupleType::t})) all += sent(request) + "; ";
  EXPECT_EQ(all, "49 01 00 02; 49 01 03 00; 49 01 11 02; ");
}

TEST(MccUsbTempSetup, DescribesPlatinumSensorByFourCoefficients) {
  std::string all;
  for (const auto& request : mcc_setup(2, MccRtd{.wires = MccWires::four_wire, .r0_ohm = 100.02f}))
    all += sent(request) + "; ";
  EXPECT_EQ(all,
            "49 01 00 00; 49 01 01 03; 49 01 03 02; 49 01 12 02; 49 01 14 3D 0A C8 42; 49 01 16 32 11 80 3B; "
            "49 01 18 7F 05 1B B5; 49 01 1A 1D 2D 93 AC; ");
}

TEST(MccUsbTempSetup, ThermistorAndSemiconductorHaveTheirExcitationAndGain) {
  const auto thermistor = mcc_setup(0, MccThermistor{.a = 1, .b = 2, .c = 3});
  ASSERT_EQ(thermistor.size(), 7u);
  EXPECT_EQ(sent(thermistor[0]), "49 00 00 01");
  EXPECT_EQ(sent(thermistor[2]), "49 00 03 01");
  EXPECT_EQ(sent(thermistor[3]), "49 00 12 00");
  EXPECT_EQ(sent(thermistor[6]), "49 00 18 00 00 40 40");
  const auto semiconductor = mcc_setup(1, MccSemiconductor{.differential = true, .offset = 0.5f, .scale = 1});
  ASSERT_EQ(semiconductor.size(), 6u);
  EXPECT_EQ(sent(semiconductor[0]), "49 00 00 03");
  EXPECT_EQ(sent(semiconductor[1]), "49 00 01 01");
  EXPECT_EQ(sent(semiconductor[3]), "49 00 13 01");
  EXPECT_EQ(sent(semiconductor[5]), "49 00 17 00 00 80 3F");
}

}  // namespace
}  // namespace gyrotherm::drivers
