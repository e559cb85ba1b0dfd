// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <vector>

#include "apps/gyrotherm/devices.hpp"
#include "apps/gyrotherm/new_rig/interview.hpp"
#include "apps/gyrotherm/new_rig/line_answers.hpp"

namespace gyrotherm::app {
namespace {

/// Types the lines one after the other, then ends the input. Keeps what was printed and asked.
struct Typist {
  std::deque<std::string> lines;
  std::string told{};
  std::vector<std::string> asked{};
  Person person() {
    return {.tell = [this](const std::string& line) { told += line + "\n"; },
            .ask = [this](const std::string& question) -> std::optional<std::string> {
              asked.push_back(question);
              if (lines.empty()) return std::nullopt;
              auto line = lines.front();
              lines.pop_front();
              return line;
            }};
  }
};

GivenAnswers complete() {
  return {.values = {{"--chamber", "watlow_f4t"},
                     {"--chamber-line", "10.0.0.5"},
                     {"--lowest", "-40"},
                     {"--highest", "60 °C"},
                     {"--fastest", "5"},
                     {"--gyro", "pulse-count"},
                     {"--gyro-line", "tcp://10.0.0.7:4001"},
                     {"--arcsec-per-pulse", "0.1"},
                     {"--latitude", "-47.5"}},
          .scanners = {"lakeshore_218 tcp://10.0.0.6:4001 8"}};
}

Fault fault_of(const GivenAnswers& given) {
  const auto answers = collect_answers("rig.toml", given, {});
  return answers ? Fault{} : answers.error();
}

GivenAnswers with(const std::string& option, const std::string& value) {
  auto given = complete();
  given.values[option] = value;
  return given;
}

TEST(RigInterview, AsksNothingWhenOptionsAreCompleteExceptValuesWithDefault) {
  const auto answers = collect_answers("rig.toml", complete(), {});
  ASSERT_TRUE(answers) << text(answers.error());
  EXPECT_EQ(answers->chamber_line, "tcp://10.0.0.5");
  EXPECT_EQ(answers->chamber_unit, 1);
  EXPECT_EQ(answers->safe.value, 20);
  EXPECT_EQ(answers->air_lowest.value, -50);
  EXPECT_EQ(answers->air_highest.value, 70);
  EXPECT_FALSE(answers->limiter);
  EXPECT_EQ(answers->latitude, -47.5);
  EXPECT_EQ(answers->scanners.at(0).channels.size(), 8u);
  EXPECT_EQ(answers->scanners.at(0).channels.back(), "H");
  EXPECT_EQ(answers->title, "Watlow F4T, 8 thermometers, pulse-count");
}

TEST(RigInterview, NamesEveryMissingOptionTogetherWithoutTerminal) {
  const auto all = fault_of({});
  EXPECT_EQ(all.kind, FaultKind::usage);
  EXPECT_EQ(
      all.where,
      "--chamber, --chamber-line, --lowest, --highest, --fastest, --thermometer, --gyro, --gyro-line, --latitude");
  auto given = complete();
  given.values.erase("--latitude");
  EXPECT_EQ(fault_of(given).where, "--latitude");
  given = complete();
  given.values.erase("--arcsec-per-pulse");  // needed by this stream only
  EXPECT_EQ(fault_of(given).where, "--arcsec-per-pulse");
  given = complete();
  given.scanners.clear();
  EXPECT_EQ(fault_of(given).where, "--thermometer");
}

TEST(RigInterview, RefusesWrongOptionWithItsName) {
  const std::pair<const char*, const char*> kWrong[] = {{"--chamber", "watlow_f5"},
                                                        {"--chamber", ""},
                                                        {"--chamber-line", "f4t.local"},
                                                        {"--chamber-line", "virtual"},
                                                        {"--chamber-line", "hid:1"},
                                                        {"--chamber-line", "tcp://10.0.0.5:99999"},
                                                        {"--chamber-line", "serial:/dev/ttyUSB0?9601,8N1"},
                                                        {"--chamber-unit", "248"},
                                                        {"--chamber-unit", "1x"},
                                                        {"--lowest", "-40,5"},
                                                        {"--lowest", "−40"},
                                                        {"--lowest", "-300"},
                                                        {"--lowest", "nan"},
                                                        {"--highest", "-40"},
                                                        {"--fastest", "0"},
                                                        {"--fastest", "-5"},
                                                        {"--safe", "61"},
                                                        {"--air", "-39 70"},
                                                        {"--air", "70"},
                                                        {"--limiter", "4 -50 70"},
                                                        {"--limiter", "3.1 -50 70"},
                                                        {"--limiter", "3.3 -40 70"},
                                                        {"--limiter", "3.2 -40"},
                                                        {"--limiter", "3.3"},
                                                        {"--gyro", "kvh"},
                                                        {"--gyro-axis", "z"},
                                                        {"--arcsec-per-pulse", "0"},
                                                        {"--latitude", "91"},
                                                        {"--latitude", "47°30'"},
                                                        {"--azimuth", "361"},
                                                        {"--elevation", "-91"},
                                                        {"--serial-number", " "},
                                                        {"--title", "a\x1b[2J"}};
  for (const auto& [option, value] : kWrong) {
    const auto fault = fault_of(with(option, value));
    EXPECT_EQ(fault.kind == FaultKind::usage ? fault.where : text(fault), option) << value;
  }
  EXPECT_TRUE(collect_answers("rig.toml", with("--limiter", "3.3 -50 70"), {}));
  EXPECT_TRUE(collect_answers("rig.toml", with("--limiter", "3.1 75"), {}));
  EXPECT_FALSE(collect_answers("rig.toml", with("--limiter", "2 75 °C"), {}).has_value());
  EXPECT_NE(text(fault_of(with("--limiter", "3.3 75 -50"))).find("is not below the highest"), std::string::npos);
}

TEST(RigInterview, PlacesLimitsOfAirInsideThoseOfLimiter) {
  const auto limits_with = [](const std::string& limiter) {
    const auto answers = collect_answers("rig.toml", with("--limiter", limiter), {});
    EXPECT_TRUE(answers) << limiter;
    return answers ? std::pair(answers->air_lowest.value, answers->air_highest.value) : std::pair(0.0, 0.0);
  };
  EXPECT_EQ(limits_with("3.3 -45 65"), std::pair(-42.5, 62.5));
  EXPECT_EQ(limits_with("3.3 -80 61"), std::pair(-50.0, 60.5));
  EXPECT_EQ(limits_with("3.1 66"), std::pair(-50.0, 63.0));
  EXPECT_EQ(limits_with("3.2 -42"), std::pair(-41.0, 70.0));
  EXPECT_EQ(limits_with("unknown"), std::pair(-50.0, 70.0));
  auto given = with("--limiter", "3.3 -45 65");
  given.values["--air"] = "-44 64";
  EXPECT_TRUE(collect_answers("rig.toml", given, {}));
  for (const auto* air : {"-45 64", "-44 65", "-50 70"}) {
    given.values["--air"] = air;
    EXPECT_NE(text(fault_of(given)).find("the limiter would trip first"), std::string::npos) << air;
  }
}

TEST(RigInterview, RefusesScannersThatDoNotFit) {
  for (const char* wrong :
       {"", "lakeshore_218", "lakeshore_218 tcp://10.0.0.6", "lakeshore_219 tcp://10.0.0.6 8",
        "lakeshore_218 tcp://10.0.0.6 9", "lakeshore_218 tcp://10.0.0.6 0", "lakeshore_218 tcp://10.0.0.6 A A",
        "lakeshore_218 tcp://10.0.0.6 air_c", "lakeshore_218 tcp://10.0.0.6 A", "dcon serial:/dev/ttyS0 A B",
        "dcon serial:/dev/ttyS0 addresses=1,256 A B", "dcon serial:/dev/ttyS0 addresses=1 type=Z A B",
        "mcc_usb_temp tcp://10.0.0.6 A B", "process tcp://10.0.0.6 A B", "text tcp://10.0.0.6 A B",
        "keysight_34970a tcp://10.0.0.6 1 2 3 4 5 6 7 8 9"}) {
    auto given = complete();
    given.scanners = {wrong};
    const auto fault = fault_of(given);
    EXPECT_EQ(fault.where, "--thermometer") << wrong;
    EXPECT_FALSE(fault.what.empty());
  }
  auto given = complete();
  given.scanners = {"lakeshore_218 serial:/dev/ttyS0 4", "pt12 serial:/dev/ttyS0?9600,8N1 shell"};
  EXPECT_EQ(fault_of(given).where, "--thermometer") << "one port for two instruments";
  given.values["--gyro-line"] = "serial:/dev/ttyS0";
  given.scanners.pop_back();
  EXPECT_EQ(fault_of(given).where, "--gyro-line");
}

TEST(RigInterview, TakesSettingsOfModulesAndCountsOnlyFreeLetters) {
  auto given = complete();
  given.scanners = {"dcon /dev/ttyS9?9600,8N1 addresses=1,2 type=T B shell", "mcc_usb_temp 01A2B3C4 4"};
  const auto answers = collect_answers("rig.toml", given, {});
  ASSERT_TRUE(answers) << text(answers.error());
  EXPECT_EQ(answers->scanners[0].line, "serial:/dev/ttyS9?9600,8N1");
  EXPECT_EQ(answers->scanners[0].addresses, (std::vector<std::uint8_t>{1, 2}));
  EXPECT_EQ(answers->scanners[1].line, "hid:01A2B3C4");
  EXPECT_EQ(answers->scanners[1].channels, (std::vector<std::string>{"A", "C", "D", "E"}));
}

TEST(RigInterview, AsksAgainWithReason) {
  Typist typist{{"watlow_f4",
                 "f4t.local",  // no line
                 "COM3",
                 "serial:/dev/ttyS0?19200,8N1",
                 "",
                 "-22,5",  // Modbus unit by default
                 "-22.5",
                 "-30",
                 "70",
                 "5 K/s",
                 "5",
                 "",
                 "",
                 "",
                 "none",
                 "lakeshore_218",
                 "serial:/dev/ttyS0",
                 "tcp://10.0.0.6",
                 "",
                 "none",
                 "stim300",
                 "tcp://10.0.0.7:4001",
                 "w",
                 "x",
                 "unknown",
                 "",
                 "Bench"}};
  const auto answers = collect_answers("rig.toml", {}, typist.person());
  ASSERT_TRUE(answers) << text(answers.error()) << typist.told;
  EXPECT_TRUE(typist.lines.empty());
  EXPECT_EQ(answers->chamber_line, "serial:/dev/ttyS0?19200,8N1");
  EXPECT_EQ(answers->lowest.value, -22.5);
  EXPECT_EQ(answers->scanners.size(), 1u);
  EXPECT_EQ(answers->axis, "x");
  EXPECT_FALSE(answers->latitude);
  EXPECT_EQ(answers->title, "Bench");
  for (const char* reason :
       {"host names are not resolved", "Windows port name", "decimal comma", "not above the lowest", "a rate in °C/min",
        "two thermometers at least", "already the line of another instrument", "\"w\" is not one of"})
    EXPECT_NE(typist.told.find(reason), std::string::npos) << reason;
}

TEST(RigInterview, AsksOnlyWhatOptionsLeaveOpen) {
  auto given = complete();
  given.values.erase("--latitude");
  given.values.erase("--title");
  Typist typist{{"", "47"}};
  for (const char* option : {"--chamber-unit", "--safe", "--air", "--limiter", "--azimuth", "--elevation"})
    given.values[option] = std::string(option) == "--air"       ? "-60 80"
                           : std::string(option) == "--limiter" ? "unknown"
                                                                : "20";
  typist.lines = {"", "47", "none", "none"};
  const auto answers = collect_answers("rig.toml", given, typist.person());
  ASSERT_TRUE(answers) << text(answers.error());
  EXPECT_EQ(typist.asked.size(), 4u) << "latitude twice, serial number, title";
  EXPECT_NE(typist.told.find("an answer is needed"), std::string::npos);
}

TEST(RigInterview, ReturnsToPreviousQuestion) {
  Typist typist{{"back",  // nothing to go back to
                 "f4",    // not a map
                 "watlow_f4t",
                 "tcp://10.0.0.5",
                 "",
                 "200",
                 "back",
                 "-40",
                 "60",
                 "5",
                 "",
                 "",
                 "",
                 "lakeshore_218",
                 "tcp://10.0.0.6",
                 "x",
                 "back",
                 "back",
                 "back",
                 "mcc_usb_temp",
                 "",
                 "A B",
                 "none",
                 "back",
                 "none",
                 "stim300",
                 "tcp://10.0.0.7",
                 "",
                 "back",
                 "back",
                 "tcp://10.0.0.8",
                 "",
                 "47",
                 "",
                 "",
                 "",
                 ""}};
  const auto answers = collect_answers("rig.toml", {}, typist.person());
  ASSERT_TRUE(answers) << text(answers.error()) << typist.told;
  EXPECT_EQ(answers->lowest.value, -40);
  EXPECT_EQ(answers->highest.value, 60);
  ASSERT_EQ(answers->scanners.size(), 1u);
  EXPECT_EQ(answers->scanners[0].kind, "mcc_usb_temp");
  EXPECT_EQ(answers->scanners[0].channels, (std::vector<std::string>{"A", "B"}));
  EXPECT_EQ(answers->gyro_line, "tcp://10.0.0.8");
  for (const auto* told : {"this is the first question", "did you mean \"watlow_f4\"", "other-modbus and other-text"})
    EXPECT_NE(typist.told.find(told), std::string::npos) << told;
}

TEST(RigInterview, EndsAtEndOfInput) {
  const std::vector<std::string> kAnswers{
      "watlow_f4t", "tcp://10.0.0.5", "", "-40", "60", "5", "", "", "", "lakeshore_218", "tcp://10.0.0.6", "", "none",
      "stim300",    "tcp://10.0.0.7", "", "47",  "",   "",  "", ""};
  for (std::size_t typed = 0; typed < kAnswers.size(); ++typed) {
    Typist typist{{kAnswers.begin(), kAnswers.begin() + static_cast<std::ptrdiff_t>(typed)}};
    const auto answers = collect_answers("rig.toml", {}, typist.person());
    ASSERT_FALSE(answers) << typed;
    EXPECT_EQ(answers.error().kind, FaultKind::usage);
    EXPECT_TRUE(answers.error().where.starts_with("--")) << text(answers.error());
    EXPECT_NE(answers.error().what.find("the input ended"), std::string::npos) << typed;
  }
  Typist typist{{kAnswers.begin(), kAnswers.end()}};
  EXPECT_TRUE(collect_answers("rig.toml", {}, typist.person()));
}

TEST(DeviceLines, NameStablePathOrSerialNumber) {
  Device serial{.node = {"/dev/ttyUSB0", true, "dialout"}};
  serial.line = "serial:/dev/serial/by-id/usb-FTDI_FT123456-if00-port0";
  const auto lines = rig_file_lines(serial);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0].starts_with("line = \"serial:/dev/serial/by-id/usb-FTDI_FT123456-if00-port0\"  # append"));
  serial.line = "serial:/dev/ttyS0";
  EXPECT_NE(rig_file_lines(serial)[0].find("this name may change"), std::string::npos);
  Device hid{.node = {"/dev/hidraw0", true, "dialout"}, .is_hid = true};
  EXPECT_TRUE(rig_file_lines(hid).empty()) << "no driver";
  hid.line = "hid:01A2B3C4";
  EXPECT_EQ(rig_file_lines(hid),
            (std::vector<std::string>{"[[thermometer]]", "driver = \"mcc_usb_temp\"", "line = \"hid:01A2B3C4\""}));
}

}  // namespace
}  // namespace gyrotherm::app
