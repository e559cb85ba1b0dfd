// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/lakeshore_218.hpp"

#include <gtest/gtest.h>

#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr const char* kEight = "+20.123,+21.1,-040.25,+023.4567,+24.,+25.5,+26.6,+300.00";
const std::vector<double> kValues{20.123, 21.1, -40.25, 23.4567, 24, 25.5, 26.6, 300};

TEST(Lakeshore218Codec, ReadsAnyNumberOfDecimals) {
  const auto readings = decode_crdg(kEight);
  ASSERT_TRUE(readings) << text(readings.error());
  ASSERT_EQ(readings->size(), kLakeshore218Inputs);
  for (std::size_t i = 0; i < kValues.size(); ++i) EXPECT_DOUBLE_EQ((*readings)[i].value().value, kValues[i]);
}

// Sample reply in the manual.
TEST(Lakeshore218Codec, ReadsTheReplyOfTheManual) {
  const auto readings = decode_crdg("+480.00,+480.00,+480.00,+480.00,+01.000,+01.000,+01.000,+01.000").value();
  EXPECT_EQ(readings[0].value(), Celsius{480});
  EXPECT_EQ(readings[7].value(), Celsius{1});
}

TEST(Lakeshore218Codec, AnythingButEightNumbersIsCorrupted) {
  for (const char* wrong : {"", "+1", "+1,+2,+3,+4,+5,+6,+7", "+1,+2,+3,+4,+5,+6,+7,+8,+9", "+1,+2,+3,+4,+5,+6,+7,+8,",
                            "1,+2,+3,+4,+5,+6,+7,+8", "+1,+2,+3,+4,+5,+6,+7,+nan", "+1,+2,+3,+4,+5,+6,+7,+8e1",
                            "+1,+2,+3,+4,+5,+6,+7,+", "+1,+2,+3,+4,+5,+6,+7,++8", "+1,+2,+3,+4,+5,+6,+7, +8"})
    EXPECT_EQ(decode_crdg(wrong).error().kind, FaultKind::corrupted) << wrong;
}

TEST(Lakeshore218Codec, ReportsImpossibleReadingForItsInput) {
  const auto readings = decode_crdg("+20.0,-273.2,+1000.1,+20.0,+20.0,+20.0,+20.0,-273.15").value();
  EXPECT_TRUE(readings[0]);
  EXPECT_EQ(readings[1].error().kind, FaultKind::out_of_range);
  EXPECT_EQ(readings[2].error().where, "input 3");
  EXPECT_EQ(readings[7].error().kind, FaultKind::out_of_range) << "0 K: an input without a sensor";
}

TEST(Lakeshore218Codec, WritesAsTheInstrumentDoes) {
  const std::vector<double> celsius{20.1234, -40.25, 0, 1, 2, 3, 4, 105.5};
  EXPECT_EQ(encode_crdg(celsius, 3), "+020.123,-040.250,+000.000,+001.000,+002.000,+003.000,+004.000,+105.500");
  EXPECT_TRUE(decode_crdg(encode_crdg(celsius, 3)));
}

class OnFakeLine : public testing::Test {
 protected:
  OnFakeLine() {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [](std::string_view query) -> std::string {
      if (query == "*IDN?\r\n") return "LSCI,MODEL218E,21EA4F,042109\r\n";
      if (query == "CRDG? 0\r\n") return std::string(kEight) + "\r\n";
      return "";
    };
    bank = make_lakeshore_218(std::move(made), "bank");
  }
  tests::FakeStream* line{};
  std::unique_ptr<Thermometer> bank;
};
using Lakeshore218 = OnFakeLine;

TEST_F(Lakeshore218, ReportsModel) { EXPECT_EQ(bank->identify().value(), "LSCI,MODEL218E,21EA4F,042109"); }

TEST_F(Lakeshore218, AnotherInstrumentIsAMismatch) {
  line->instrument = [](std::string_view) { return std::string("LSCI,MODEL340,1,2\r\n"); };
  EXPECT_EQ(bank->identify().error().kind, FaultKind::mismatch);
}

/// After a lost answer, another scanner of the same or of another model answers.
TEST_F(Lakeshore218, RejectsExchangedInstrumentAfterLostAnswer) {
  const auto answers_as = [](const std::string& who) {
    return [who](std::string_view query) -> std::string {
      if (query == "*IDN?\r\n") return who + "\r\n";
      return query == "CRDG? 0\r\n" ? std::string(kEight) + "\r\n" : "";
    };
  };
  for (const auto* other : {"LSCI,MODEL218E,21EA50,042109", "LSCI,MODEL218S,21EA4F,042109", "LSCI,MODEL240,1,2"}) {
    auto made = std::make_unique<tests::FakeStream>();
    auto& scanner = *made;
    scanner.instrument = answers_as("LSCI,MODEL218E,21EA4F,042109");
    bank = make_lakeshore_218(std::move(made), "bank");
    ASSERT_TRUE(bank->identify());
    ASSERT_TRUE(bank->read()[0]);
    scanner.fall_silent();
    (void)bank->read();
    scanner.recover();
    scanner.instrument = answers_as(other);
    for (const auto& reading : bank->read()) EXPECT_FALSE(reading) << other;
  }
}

TEST_F(Lakeshore218, ReadsAllInputsWithOneQuery) {
  const auto readings = bank->read();
  ASSERT_EQ(readings.size(), 8u);
  for (std::size_t i = 0; i < readings.size(); ++i) EXPECT_DOUBLE_EQ(readings[i].value().value, kValues[i]);
  EXPECT_EQ(line->heard.size(), 1u);
}

TEST_F(Lakeshore218, AcceptsReplyByteByByte) {
  line->limit_read_size(1);
  EXPECT_TRUE(bank->read()[7]);
}

void expect_all(const std::vector<Result<Celsius>>& readings, FaultKind kind) {
  ASSERT_EQ(readings.size(), 8u);
  for (const auto& reading : readings) EXPECT_EQ(reading.error().kind, kind);
}

TEST_F(Lakeshore218, ReportsTimeoutForEveryInput) {
  line->fall_silent();
  expect_all(bank->read(), FaultKind::timeout);
  line->recover();
  EXPECT_TRUE(bank->read()[0]);
}

TEST_F(Lakeshore218, DoesNotTakeLateReplyForNext) {
  line->answer_late();
  expect_all(bank->read(), FaultKind::timeout);
  line->recover();
  line->say("+99.0,+99.0,+99.0,+99.0,+99.0,+99.0,+99.0,+99.0\r\n");
  EXPECT_DOUBLE_EQ(bank->read()[0].value().value, kValues[0]);
}

TEST_F(Lakeshore218, TwoRepliesToOneQueryAreCorrupted) {
  line->instrument = [](std::string_view) { return std::string(kEight) + "\r\n" + kEight + "\r\n"; };
  expect_all(bank->read(), FaultKind::corrupted);
}

TEST_F(Lakeshore218, EndsExchangeWithinLimit) {
  EXPECT_LE(3 * Lakeshore218Timing{}.within, std::chrono::milliseconds(1500));
}

TEST_F(Lakeshore218, YieldsNoReadingFromGarbledReply) {
  line->garble();
  const auto readings = bank->read();
  for (const auto& reading : readings) EXPECT_FALSE(reading);
  line->recover();
  EXPECT_TRUE(bank->read()[0]);
}

TEST_F(Lakeshore218, RejectsLineWithoutEnd) {
  line->instrument = [](std::string_view) { return std::string(1000, '+'); };
  expect_all(bank->read(), FaultKind::corrupted);
}

TEST_F(Lakeshore218, NamesInstrumentOfBrokenLine) {
  line->disconnect();
  expect_all(bank->read(), FaultKind::disconnected);
  EXPECT_EQ(bank->read()[3].error().where, "bank fake");
}

}  // namespace
}  // namespace gyrotherm::drivers
