// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/pt12.hpp"

#include <gtest/gtest.h>

#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

class Pt12 : public testing::Test {
 protected:
  Pt12() {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [](std::string_view query) -> std::string {
      if (query == "ID?\r") return "PT12\r\n";
      if (query == "SN?\r") return "T21X123\r\n";
      if (query == "T?\r") return "1.5, 2.5, NaN, -4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 10.5, 11.5, 12.5\r\n";
      return "";
    };
    bank = make_pt12(std::move(made), "bank");
  }
  void expect_all(FaultKind kind) {
    const auto readings = bank->read();
    ASSERT_EQ(readings.size(), kPt12Inputs);
    for (const auto& reading : readings) EXPECT_EQ(reading.error().kind, kind);
  }
  tests::FakeStream* line{};
  std::unique_ptr<Thermometer> bank;
};

TEST_F(Pt12, ReportsSerialNumber) { EXPECT_EQ(bank->identify().value(), "PT12 T21X123"); }

TEST_F(Pt12, AnotherInstrumentIsAMismatch) {
  line->instrument = [](std::string_view) { return std::string("T1\r\n"); };
  EXPECT_EQ(bank->identify().error().kind, FaultKind::mismatch);
}

TEST_F(Pt12, ReadsAllInputsWithOneQuestion) {
  const auto readings = bank->read();
  ASSERT_EQ(readings.size(), kPt12Inputs);
  EXPECT_EQ(line->heard, std::vector<std::string>{"T?\r"});
  EXPECT_EQ(readings[3].value(), Celsius{-4.5});
  EXPECT_EQ(readings[11].value(), Celsius{12.5});
  EXPECT_EQ(text(readings[2].error()), "bank T3: no probe is connected (NaN)");
}

TEST_F(Pt12, AcceptsAnswerByteByByte) {
  line->limit_read_size(1);
  EXPECT_TRUE(bank->read()[11]);
}

TEST_F(Pt12, ReportsTimeoutForEveryInput) {
  line->fall_silent();
  expect_all(FaultKind::timeout);
  line->recover();
  EXPECT_TRUE(bank->read()[0]);
}

TEST_F(Pt12, DoesNotTakeLateAnswerForNext) {
  line->answer_late();
  expect_all(FaultKind::timeout);
  line->recover();
  line->say("99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99\r\n");
  EXPECT_EQ(bank->read()[0].value(), Celsius{1.5});
}

TEST_F(Pt12, YieldsNoReadingFromGarbledAnswer) {
  line->garble();
  for (const auto& reading : bank->read()) EXPECT_FALSE(reading);
  line->recover();
  EXPECT_TRUE(bank->read()[0]);
}

TEST_F(Pt12, RejectsLineWithoutEnd) {
  line->instrument = [](std::string_view) { return std::string(1000, '1'); };
  expect_all(FaultKind::corrupted);
}

TEST_F(Pt12, NamesInstrumentOfBrokenLine) {
  line->disconnect();
  expect_all(FaultKind::disconnected);
  EXPECT_EQ(bank->read()[3].error().where, "bank fake");
}

}  // namespace
}  // namespace gyrotherm::drivers
