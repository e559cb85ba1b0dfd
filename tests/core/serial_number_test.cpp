// SPDX-License-Identifier: Apache-2.0
#include "core/serial_number.hpp"

#include <gtest/gtest.h>

#include <string>

namespace gyrotherm {
namespace {

using std::string_literals::operator""s;

TEST(SerialNumber, KeepsZerosCaseAndInnerBlanks) {
  for (const auto* number : {"0042", "42", "RLG-1 0042", "aB/7", "№ 5", "]d20100042", "=42", "u1=0042"})
    EXPECT_EQ(parse_serial_number(number).value_or("none"), number);
  EXPECT_EQ(parse_serial_number(std::string(kLongestSerialNumber, '7')).value_or(""), std::string(64, '7'));
}

TEST(SerialNumber, IsTrimmed) {
  for (const auto* sent : {" 0042", "0042\r", "0042\r\n", "\t0042 ", "0042\n"})
    EXPECT_EQ(parse_serial_number(sent).value_or("none"), "0042") << testing::PrintToString(sent);
}

TEST(SerialNumber, IsRefusedWithCause) {
  const auto refusal = [](const std::string& text) {
    const auto parsed = parse_serial_number(text);
    EXPECT_FALSE(parsed);
    if (parsed) return *parsed;
    EXPECT_EQ(parsed.error().kind, FaultKind::usage);
    return parsed.error().what;
  };
  EXPECT_EQ(refusal(""), "is empty");
  EXPECT_EQ(refusal(" \t\r\n"), "is empty");
  EXPECT_EQ(refusal("01\x1d\x32\x31"),
            "\"01\\x1d21\" contains the character \\x1d at position 3; set the bar-code "
            "reader to send only the number and Enter");
  EXPECT_NE(refusal("00\n42").find("\\x0a at position 3"), std::string::npos) << "two numbers in one scan";
  EXPECT_NE(refusal("0\0001"s).find("\\x00 at position 2"), std::string::npos);
  EXPECT_NE(refusal("0\xff").find("\\xff at position 2"), std::string::npos) << "no UTF-8";
  EXPECT_NE(refusal("№\xe2\x80\xae"
                    "24")
                .find("\\u202e at position 2"),
            std::string::npos)
      << "a writing direction";
  EXPECT_NE(refusal("0\x1b[2J").find("\\x1b at position 2"), std::string::npos) << "controls a terminal";
  EXPECT_NE(refusal(std::string(65, '7')).find("has 65 bytes, expected at most 64"), std::string::npos);
}

TEST(SerialNumber, IsFoundAsToken) {
  for (const auto* identity : {"0042", "SN 0042", "SN0042", "SN 42", "SN 00042", "gyro 1.2, 0042, 9600", "10042 0042"})
    EXPECT_TRUE(contains_serial_number(identity, "0042")) << identity;
  for (const auto* identity : {"", "SN 4", "SN 10042", "SN 100042", "SN 00421", "0042A"})
    EXPECT_FALSE(contains_serial_number(identity, "0042")) << identity;
  EXPECT_TRUE(contains_serial_number("V-0101", "V-0101"));
  EXPECT_FALSE(contains_serial_number("RV-0101", "V-0101"));
  EXPECT_TRUE(contains_serial_number("SN 0", "000"));
  EXPECT_FALSE(contains_serial_number("SN 10", "0"));
  EXPECT_FALSE(contains_serial_number("SN 0042", ""));
}

}  // namespace
}  // namespace gyrotherm
