// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "drivers/thermometer/dcon_thermometer.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr TemperatureRange kTypeT{{-100}, {400}};
const std::vector<TemperatureRange> kEight(kDconInputs, kTypeT), kOne(1, kTypeT);
// Sample reply in the manual.
constexpr const char* kSample = ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345+08.234";
constexpr double kValues[] = {5.123, 4.153, 7.234, -2.356, 10.000, -5.133, 2.345, 8.234};

TEST(DconCodec, AsksInTwoHexadecimalDigits) {
  EXPECT_EQ(dcon_read_all(0x04), "#04");
  EXPECT_EQ(dcon_read_all(0xFE), "#FE");
  EXPECT_EQ(dcon_query(0x0A, "2"), "$0A2");
}

TEST(DconCodec, SealsWithTheSumOfTheCharacters) {
  EXPECT_EQ(seal_dcon("$012", DconChecksum::on), "$012B7");
  EXPECT_EQ(seal_dcon("!01200600", DconChecksum::on), "!01200600AA");
  EXPECT_EQ(seal_dcon("!01400600", DconChecksum::on), "!01400600AC");
  EXPECT_EQ(seal_dcon("$012", DconChecksum::off), "$012");
}

TEST(DconCodec, RejectsWrongChecksum) {
  EXPECT_EQ(unseal_dcon("!01200600AA", DconChecksum::on).value(), "!01200600");
  EXPECT_EQ(unseal_dcon("!01200600", DconChecksum::off).value(), "!01200600");
  for (const char* wrong : {"", "A", "!01200600", "!01200600AB", "!01200600aa", "!01200601AA", "!01200600AA "})
    EXPECT_EQ(unseal_dcon(wrong, DconChecksum::on).error().kind, FaultKind::corrupted) << wrong;
}

TEST(DconCodec, ReadsTheReplyOfTheManual) {
  const auto readings = decode_dcon_readings(kSample, 4, kEight).value();
  ASSERT_EQ(readings.size(), kDconInputs);
  for (std::size_t i = 0; i < kDconInputs; ++i) EXPECT_DOUBLE_EQ(readings[i].value().value, kValues[i]);
}

TEST(DconCodec, ReadsOneInput) {
  const auto readings = decode_dcon_readings(">+02.513", 3, kOne).value();
  ASSERT_EQ(readings.size(), 1u);
  EXPECT_EQ(readings[0].value(), Celsius{2.513});
}

TEST(DconCodec, OverAndUnderRangeAreFaultsInTheirPlace) {
  const auto readings =
      decode_dcon_readings(">+9999-0000+025.12-000.00+025.12+400.01-100.01-100.00", 1, kEight).value();
  EXPECT_EQ(text(readings[0].error()), "input 0: over range (+9999)");
  EXPECT_EQ(text(readings[1].error()), "input 1: under range (-0000)");
  EXPECT_EQ(readings[2].value(), Celsius{25.12});
  // A zero rounded up from below is a valid reading.
  EXPECT_EQ(readings[3].value(), Celsius{0});
  EXPECT_EQ(readings[5].error().where, "input 5");
  EXPECT_EQ(readings[6].error().kind, FaultKind::out_of_range);
  EXPECT_EQ(readings[7].value(), Celsius{-100});
  const auto none = decode_dcon_readings(">+9999+9999+9999+9999-0000-0000-0000-0000", 1, kEight).value();
  for (const auto& reading : none) EXPECT_FALSE(reading);
}

TEST(DconCodec, AnythingButEightValuesIsCorrupted) {
  for (const char* wrong :
       {"", ">", "!04", ">+05.123", ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345",
        ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345+08.234+01.000",
        "+05.123+04.153+07.234-02.356+10.000-05.133+02.345+08.234",
        ">05.123+04.153+07.234-02.356+10.000-05.133+02.345+08.234",
        ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345+",
        ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345+082340",
        ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345+08.23e",
        ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345+08..34",
        ">+05.123+04.153+07.234-02.356+10.000-05.133+02.345+08.23 ", ">4C534C534C534C534C534C534C534C53"})
    EXPECT_EQ(decode_dcon_readings(wrong, 4, kEight).error().kind, FaultKind::corrupted) << wrong;
}

// Its two digits would extend the last reading.
TEST(DconCodec, DoesNotDecodeUnexpectedChecksumAsDecimals) {
  for (unsigned sum = 0; sum < 100; ++sum) {
    EXPECT_FALSE(decode_dcon_readings(fmt::format("{}{:02}", kSample, sum), 4, kEight)) << sum;
    EXPECT_FALSE(decode_dcon_readings(fmt::format(">+02.513{:02}", sum), 4, kOne)) << sum;
    EXPECT_FALSE(decode_dcon_readings(fmt::format(">-0000{:02}", sum), 4, kOne)) << sum;
  }
}

TEST(DconCodec, NamesModuleOfRefusal) {
  EXPECT_EQ(decode_dcon_readings("?04", 4, kEight).error().kind, FaultKind::refused);
  EXPECT_EQ(decode_dcon_answer("?02", 2).error().kind, FaultKind::refused);
}

TEST(DconCodec, AnotherModulesAnswerIsCorrupted) {
  EXPECT_EQ(decode_dcon_readings("?05", 4, kEight).error().kind, FaultKind::corrupted);
  for (const char* wrong : {"", "!", "!0", "!02100600", "?02", "?01 ", ">01", "01100600", "!1100600"})
    EXPECT_EQ(decode_dcon_answer(wrong, 1).error().kind, FaultKind::corrupted) << wrong;
  EXPECT_EQ(decode_dcon_answer("!01", 1).value(), "");
}

TEST(DconCodec, ReadsTheConfiguration) {
  const auto of_manual = decode_dcon_answer("!01200600", 1).and_then(decode_dcon_configuration).value();
  EXPECT_EQ(of_manual, (DconConfiguration{.type = 0x20, .baud = 0x06, .format = 0x00}));
  EXPECT_TRUE(of_manual.in_engineering_units());
  EXPECT_EQ(of_manual.checksum(), DconChecksum::off);
  const auto other = decode_dcon_configuration("1006C1").value();
  EXPECT_FALSE(other.in_engineering_units());
  EXPECT_EQ(other.checksum(), DconChecksum::on);
  EXPECT_EQ(encode_dcon_configuration(other), "1006C1");
  for (const char* wrong : {"", "10060", "1006000", "1006g0", "1006c1", "+10600"})
    EXPECT_EQ(decode_dcon_configuration(wrong).error().kind, FaultKind::corrupted) << wrong;
}

TEST(DconCodec, ReadsTheTypeOfOneInput) {
  EXPECT_EQ(dcon_query(1, "8C0"), "$018C0");
  EXPECT_EQ(decode_dcon_answer("!01C0R20", 1).and_then([](auto rest) { return decode_dcon_type(rest, 0); }).value(),
            0x20);
  for (const char* wrong : {"", "C0", "C0R", "C0R2", "C1R20", "C0R200", "C0S20", "C0Rg0"})
    EXPECT_EQ(decode_dcon_type(wrong, 0).error().kind, FaultKind::corrupted) << wrong;
}

TEST(DconCodec, EachInputHasItsOwnRange) {
  auto ranges = kEight;
  ranges[2] = dcon_range(0x0E).value();
  const auto readings =
      decode_dcon_readings(">-040.00-040.00-040.00-040.00-040.00-040.00-040.00-040.00", 1, ranges).value();
  for (std::size_t i = 0; i < kDconInputs; ++i) EXPECT_EQ(readings[i].has_value(), i != 2) << i;
}

TEST(DconCodec, OnlyTypeTGoesBelowZero) {
  for (int type = 0; type < 256; ++type) {
    const auto range = dcon_range(static_cast<std::uint8_t>(type));
    EXPECT_EQ(range.has_value(), type >= 0x0E && type <= 0x11) << type;
    if (range) {
      EXPECT_EQ(range->lowest < Celsius{0}, type == 0x10);
    }
  }
}

TEST(DconCodec, WhatEncodesDecodesToTheSame) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 1000; ++round) {
    std::vector<double> celsius;
    for (std::size_t i = 0; i < kDconInputs; ++i)
      celsius.push_back((static_cast<int>(random() % 70000) - 20000) / 100.);
    const auto sealed = seal_dcon(encode_dcon_readings(celsius, kTypeT, 2), DconChecksum::on);
    const auto readings = unseal_dcon(sealed, DconChecksum::on)
                              .and_then([](std::string_view line) { return decode_dcon_readings(line, 1, kEight); })
                              .value();
    for (std::size_t i = 0; i < kDconInputs; ++i) {
      const bool possible = celsius[i] >= -100 && celsius[i] <= 400;
      ASSERT_EQ(readings[i].has_value(), possible) << "seed " << kSeed << " round " << round << ": " << celsius[i];
      if (!possible) continue;
      EXPECT_DOUBLE_EQ(readings[i]->value, celsius[i]) << "seed " << kSeed << " round " << round;
    }
  }
}

TEST(DconCodec, OneWrongCharacterNeverPassesTheChecksum) {
  const auto sealed = seal_dcon(kSample, DconChecksum::on);
  for (std::size_t i = 0; i < sealed.size(); ++i)
    for (char c = 32; c < 127; ++c) {
      auto wrong = sealed;
      wrong[i] = c;
      EXPECT_EQ(unseal_dcon(wrong, DconChecksum::on).has_value(), wrong == sealed) << wrong;
    }
}

}  // namespace
}  // namespace gyrotherm::drivers
