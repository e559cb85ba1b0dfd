// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/dcon_thermometer.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <tuple>

#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

/// An in-memory module that reports its settings and readings.
struct Module {
  std::uint8_t address = 4;
  DconChecksum checksum = DconChecksum::off;
  std::string name = "7018P";
  std::string configuration = "100600";
  /// Types of the inputs, one after the other; if empty, the module does not support the query.
  std::string types = "";
  std::string readings = ">+05.123+04.153+07.234-02.356+10.000-05.133+9999-0000";

  [[nodiscard]] std::string operator()(std::string_view query) const {
    const auto question = unseal_dcon(query.substr(0, query.size() - 1), checksum);
    if (!query.ends_with('\r') || !question) return "";
    const auto answer = reply(*question);
    return answer.empty() ? "" : seal_dcon(answer, checksum) + "\r";
  }

 private:
  [[nodiscard]] std::string reply(std::string_view question) const {
    const auto me = dcon_read_all(address).substr(1);
    if (question == "#" + me) return readings;
    if (question == "$" + me + "2") return "!" + me + configuration;
    if (question == "$" + me + "M") return "!" + me + name;
    if (question.starts_with("$" + me + "8C")) {
      const auto input = static_cast<std::size_t>(question.back() - '0');
      return types.empty() ? "?" + me : "!" + me + "C" + question.back() + "R" + types.substr(2 * input, 2);
    }
    return question.substr(1, 2) == me ? "?" + me : "";
  }
};

class OnModule : public testing::Test {
 protected:
  OnModule() { connect({.address = 4}); }
  void connect(DconOptions options) {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [this](std::string_view query) { return module(query); };
    bank = make_dcon_thermometer(std::move(made), "bank", options);
  }
  void expect_all(FaultKind kind) {
    const auto readings = bank->read();
    ASSERT_EQ(readings.size(), kDconInputs);
    for (const auto& reading : readings) EXPECT_EQ(reading.error().kind, kind) << text(reading.error());
  }
  Module module;
  tests::FakeStream* line{};
  std::unique_ptr<Thermometer> bank;
};
using DconThermometer = OnModule;

TEST_F(DconThermometer, ReportsModelAndAddress) { EXPECT_EQ(bank->identify().value(), "7018P at 04, type 10"); }

TEST_F(DconThermometer, ReadsAllInputsWithOneQuestion) {
  ASSERT_TRUE(bank->identify());
  const auto before = line->heard.size();
  const auto readings = bank->read();
  ASSERT_EQ(readings.size(), kDconInputs);
  EXPECT_EQ(line->heard.size(), before + 1);
  EXPECT_EQ(line->heard.back(), "#04\r");
  EXPECT_EQ(readings[3].value(), Celsius{-2.356});
  EXPECT_EQ(text(readings[6].error()), "bank input 6: over range (+9999)");
  EXPECT_EQ(text(readings[7].error()), "bank input 7: under range (-0000)");
}

TEST_F(DconThermometer, AddsChecksumIfModuleDoes) {
  module.checksum = DconChecksum::on;
  connect({.address = 4, .checksum = DconChecksum::on});
  EXPECT_EQ(bank->read()[0].value(), Celsius{5.123});
  EXPECT_EQ(line->heard.back(), "#0487\r");  // 23 + 30 + 34 = 87, hexadecimal
}

TEST_F(DconThermometer, YieldsNoReadingWhenChecksumSettingDiffers) {
  module.checksum = DconChecksum::on;
  expect_all(FaultKind::timeout);
  module.checksum = DconChecksum::off;
  connect({.address = 4, .checksum = DconChecksum::on});
  for (const auto& reading : bank->read()) EXPECT_FALSE(reading);
}

TEST_F(DconThermometer, TimesOutAtWrongAddress) {
  module.address = 5;
  expect_all(FaultKind::timeout);
}

TEST_F(DconThermometer, PercentOrHexadecimalReadingsAreAMismatch) {
  for (const char* configuration : {"100601", "100602", "100603"}) {
    module.configuration = configuration;
    EXPECT_EQ(bank->identify().error().kind, FaultKind::mismatch) << configuration;
    expect_all(FaultKind::mismatch);
  }
}

TEST_F(DconThermometer, ReportsMismatchOfVoltageInput) {
  module.configuration = "050600";
  EXPECT_EQ(text(bank->identify().error()), "bank: set to type 05, expected thermocouple J, K, T or E (0E to 11)");
  expect_all(FaultKind::mismatch);
}

TEST_F(DconThermometer, InputsMayHaveATypeEach) {
  module.configuration = "000600";
  module.types = "10101010100F1010";
  const auto readings = bank->read();
  EXPECT_EQ(readings[3].value(), Celsius{-2.356});
  EXPECT_EQ(readings[5].error().kind, FaultKind::out_of_range);  // type K ends at 0 °C
  module.types = "1010101010071010";
  connect({.address = 4});
  EXPECT_EQ(bank->identify().error().where, "bank input 5");
}

TEST_F(DconThermometer, ReportsMismatchAfterModuleIsExchanged) {
  EXPECT_TRUE(bank->read()[0]);
  line->fall_silent();
  expect_all(FaultKind::timeout);
  line->recover();
  module.configuration = "100602";
  expect_all(FaultKind::mismatch);
}

TEST_F(DconThermometer, AcceptsAnswerByteByByte) {
  line->limit_read_size(1);
  EXPECT_TRUE(bank->read()[0]);
}

TEST_F(DconThermometer, DoesNotTakeLateAnswerForNext) {
  ASSERT_TRUE(bank->identify());
  line->answer_late();
  expect_all(FaultKind::timeout);
  line->recover();
  line->say(">+99.000+99.000+99.000+99.000+99.000+99.000+99.000+99.000\r");
  EXPECT_EQ(bank->read()[0].value(), Celsius{5.123});
}

TEST_F(DconThermometer, YieldsNoReadingFromGarbledAnswer) {
  line->garble();
  for (const auto& reading : bank->read()) EXPECT_FALSE(reading);
  line->recover();
  EXPECT_TRUE(bank->read()[0]);
}

TEST_F(DconThermometer, NamesInstrumentOfBrokenLine) {
  line->disconnect();
  expect_all(FaultKind::disconnected);
  EXPECT_EQ(bank->read()[3].error().where, "bank fake");
}

TEST_F(OnModule, ReportsMismatchIfTypeDiffersFromRig) {
  connect({.address = 4, .type = 0x0F});
  expect_all(FaultKind::mismatch);
  connect({.address = 4, .type = 0x10});
  EXPECT_TRUE(bank->read()[0]);
}

TEST_F(DconThermometer, RejectsExchangedModuleAfterLostAnswer) {
  for (const auto& [name, configuration, types] :
       std::vector<std::tuple<std::string, std::string, std::string>>{{"7018P", "0F0600", ""},
                                                                      {"7018P", "FF0600", "0F0F0F0F0F0F0F0F"},
                                                                      {"4018", "100600", ""},
                                                                      {"7019", "100600", ""}}) {
    VirtualClock clock;
    connect({.address = 4, .clock = &clock});
    module = {};
    ASSERT_TRUE(bank->identify());
    ASSERT_TRUE(bank->read()[0]);
    line->fall_silent();
    (void)bank->read();
    line->recover();
    module.name = name;
    module.configuration = configuration;
    module.types = types;
    for (const auto& reading : bank->read()) EXPECT_FALSE(reading) << name << " " << configuration;
    // The line rests after lost answers.
    clock.advance(std::chrono::seconds(4));
    const auto other = bank->identify();
    ASSERT_TRUE(other);
    EXPECT_NE(*other, "7018P at 04, type 10");
  }
}

/// Two modules on one line; the second can fall silent.
class OnTwoModules : public testing::Test {
 protected:
  OnTwoModules() {
    second.address = 5;
    second.readings = ">+01.000+02.000+03.000+04.000+05.000+06.000+07.000+08.000";
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [this](std::string_view query) {
      const auto answer = first(query);
      return answer.empty() && !silent ? second(query) : answer;
    };
    bank = make_dcon_modules(std::move(made), "bank", {4, 5});
  }
  Module first, second;
  bool silent = false;
  tests::FakeStream* line{};
  std::unique_ptr<Thermometer> bank;
};
using DconModules = OnTwoModules;

TEST_F(DconModules, ReturnInputsInOrderOfModules) {
  EXPECT_EQ(bank->identify().value(), "7018P at 04, type 10, 7018P at 05, type 10");
  const auto readings = bank->read();
  ASSERT_EQ(readings.size(), 16u);
  EXPECT_EQ(readings[0].value(), Celsius{5.123});
  EXPECT_EQ(readings[8].value(), Celsius{1});
  EXPECT_EQ(readings[15].value(), Celsius{8});
}

TEST_F(DconModules, SkipSilentModuleAndReadTheOther) {
  silent = true;
  for (int i = 0; i < 5; ++i) {
    const auto readings = bank->read();
    ASSERT_TRUE(readings[0]) << i;
    ASSERT_EQ(readings[8].error().kind, FaultKind::timeout) << i;
    EXPECT_EQ(readings[8].error().where.substr(0, 14), "bank module 05");
  }
  const auto asked = std::ranges::count_if(line->heard, [](const auto& text) { return text.starts_with("$052"); });
  EXPECT_EQ(asked, 2) << "it rests after the second failure";
}

TEST_F(DconModules, CountBreakAfterSilence) {
  VirtualClock clock;
  auto made = std::make_unique<tests::FakeStream>();
  made->instrument = [this](std::string_view query) {
    const auto answer = first(query);
    return answer.empty() && !silent ? second(query) : answer;
  };
  bank = make_dcon_modules(std::move(made), "bank", {4, 5}, {.clock = &clock});
  ASSERT_TRUE(bank->identify());
  const auto read = [&](int times) {
    for (; times > 0; --times, clock.advance(std::chrono::seconds(20))) (void)bank->read();
  };
  read(3);
  EXPECT_EQ(bank->breaks(), 0u);
  silent = true;
  read(4);
  EXPECT_EQ(bank->breaks(), 0u);
  silent = false;
  read(2);
  EXPECT_EQ(bank->breaks(), 1u);
}

}  // namespace
}  // namespace gyrotherm::drivers
