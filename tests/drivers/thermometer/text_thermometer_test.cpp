// SPDX-License-Identifier: Apache-2.0
// The scripted instruments follow published lines and manuals, not the files of profiles/thermometers.
#include "drivers/thermometer/text_thermometer.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

ThermometerDescription read_shipped(const std::string& name) {
  const auto file = GYROTHERM_SOURCE_DIR "/profiles/thermometers/" + name + ".toml";
  auto description = parse_thermometer_description(read_text_file(file).value_or(""), file);
  EXPECT_TRUE(description) << text(description.error());
  return std::move(*description);
}

constexpr const char* kScan = "INIT;*OPC?;FETC?";

/// A 34970A with a 34901A (user's guide, "Remote Interface Reference"). Numbers have eight decimals and an exponent; an
/// unknown command adds error −113 to the queue; readings exist only after a scan of a configured list.
class Scripted34970A {
 public:
  std::vector<std::string> readings{"+2.01230000E+01", "+2.11000000E+01", "-4.02500000E+01", "+2.34567000E+01",
                                    "+2.40000000E+01", "+2.55000000E+01", "+2.66000000E+01", "+3.00000000E+02"};
  std::string identity = "HEWLETT-PACKARD,34970A,0,13-2-2";
  std::set<std::string> unknown;

  std::string answer(std::string line) {
    if (!line.ends_with('\n')) return "";
    line.pop_back();
    if (line == "*IDN?") return identity + "\n";
    if (unknown.contains(line)) return add_error();
    if (line == "*CLS") return errors_ = 0, "";
    if (line == "CONF:TEMP FRTD,85,(@101:108)") return is_configured_ = true, "";
    if (line == kScan)
      return is_configured_ ? fmt::format("1;{}\n", fmt::join(readings, ",")) : "1;";  // no end: nothing is stored
    if (line == "SYST:ERR?") return errors_ == 0 ? "+0,\"No error\"\n" : (--errors_, "-113,\"Undefined header\"\n");
    static const std::set<std::string> other{"ABOR",
                                             "UNIT:TEMP C,(@101:108)",
                                             "SENS:TEMP:NPLC 1,(@101:108)",
                                             "FORM:READ:UNIT OFF",
                                             "FORM:READ:TIME OFF",
                                             "FORM:READ:CHAN OFF",
                                             "FORM:READ:ALAR OFF",
                                             "TRIG:SOUR IMM",
                                             "TRIG:COUN 1",
                                             "ROUT:SCAN (@101:108)"};
    return other.contains(line) ? "" : add_error();
  }
  void restart() { is_configured_ = false; }

 private:
  std::string add_error() {
    ++errors_;
    return "";
  }
  int errors_ = 0;
  bool is_configured_ = false;
};

class TextThermometer : public testing::Test {
 protected:
  TextThermometer() {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [this](std::string_view question) { return instrument.answer(std::string(question)); };
    bank = make_text_thermometer(read_shipped("keysight_34970a"), std::move(made), "bank");
  }
  [[nodiscard]] std::ptrdiff_t count_heard(const std::string& text) const {
    return std::ranges::count(line->heard, text + "\n");
  }

  Scripted34970A instrument;
  tests::FakeStream* line{};
  std::unique_ptr<Thermometer> bank;
};

void expect_all(const std::vector<Result<Celsius>>& readings, FaultKind kind) {
  ASSERT_EQ(readings.size(), 8u);
  for (const auto& reading : readings) {
    ASSERT_FALSE(reading);
    EXPECT_EQ(reading.error().kind, kind) << text(reading.error());
    EXPECT_EQ(reading.error().where, "bank");
  }
}

TEST_F(TextThermometer, PreparesTheInstrumentBeforeTheFirstReading) {
  EXPECT_EQ(bank->identify().value(), "HEWLETT-PACKARD,34970A,0,13-2-2");
  const auto readings = bank->read();
  ASSERT_EQ(readings.size(), 8u);
  const std::vector<double> expected{20.123, 21.1, -40.25, 23.4567, 24, 25.5, 26.6, 300};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_DOUBLE_EQ(readings[i].value().value, expected[i]);
  EXPECT_EQ(line->heard.front(), "*IDN?\n");
  EXPECT_EQ(line->heard[1], "ABOR\n");
  EXPECT_EQ(count_heard("CONF:TEMP FRTD,85,(@101:108)"), 1);
  const auto before = line->heard.size();
  ASSERT_TRUE(bank->read()[0]);
  EXPECT_EQ(line->heard.size(), before + 1) << "a scan takes one line, which is lost as a whole";
}

TEST_F(TextThermometer, ReadsWithoutIdentifyBefore) { EXPECT_TRUE(bank->read()[7]); }

TEST_F(TextThermometer, AnotherInstrumentIsAMismatch) {
  instrument.identity = "HEWLETT-PACKARD,34401A,0,11-5-2";
  EXPECT_EQ(bank->identify().error().kind, FaultKind::mismatch);
  expect_all(bank->read(), FaultKind::mismatch);
  EXPECT_EQ(count_heard(kScan), 0);
}

TEST_F(TextThermometer, ReportsMismatchOfUnknownPreparationCommand) {
  instrument.unknown = {"UNIT:TEMP C,(@101:108)"};
  const auto identity = bank->identify();
  ASSERT_FALSE(identity);
  EXPECT_EQ(identity.error().kind, FaultKind::mismatch);
  EXPECT_NE(identity.error().what.find("-113,\"Undefined header\""), std::string::npos) << identity.error().what;
  expect_all(bank->read(), FaultKind::mismatch);
}

TEST_F(TextThermometer, ReportsInvalidReadingAsFaultOfItsInput) {
  instrument.readings[2] = "+9.90000000E+37";
  instrument.readings[4] = "-9.90000000E+37";
  instrument.readings[5] = "+6.00100000E+02";
  instrument.readings[6] = "-2.00100000E+02";
  const auto readings = bank->read();
  for (const std::size_t valid : {0u, 1u, 3u, 7u}) EXPECT_TRUE(readings[valid]);
  for (const std::size_t invalid : {2u, 4u, 5u, 6u}) {
    ASSERT_FALSE(readings[invalid]);
    EXPECT_EQ(readings[invalid].error().kind, FaultKind::out_of_range);
    EXPECT_EQ(readings[invalid].error().where, fmt::format("bank input {}", invalid + 1));
  }
  EXPECT_NE(readings[2].error().what.find("overload"), std::string::npos);
}

TEST_F(TextThermometer, PreparesAgainAfterALostAnswer) {
  ASSERT_TRUE(bank->read()[0]);
  instrument.restart();
  line->fall_silent();
  expect_all(bank->read(), FaultKind::timeout);
  line->recover();
  EXPECT_TRUE(bank->read()[0]);
  EXPECT_EQ(count_heard("CONF:TEMP FRTD,85,(@101:108)"), 2);
}

TEST_F(TextThermometer, PreparesAgainAfterABrokenConnection) {
  ASSERT_TRUE(bank->read()[0]);
  instrument.restart();
  line->disconnect();
  expect_all(bank->read(), FaultKind::disconnected);
  EXPECT_EQ(bank->breaks(), 1u);
  line->recover();
  EXPECT_TRUE(bank->read()[0]);
  EXPECT_EQ(count_heard("*IDN?"), 2);
  EXPECT_EQ(count_heard("CONF:TEMP FRTD,85,(@101:108)"), 2);
}

TEST_F(TextThermometer, DoesNotTakeLateAnswerForNext) {
  ASSERT_TRUE(bank->read()[0]);
  line->answer_late();
  expect_all(bank->read(), FaultKind::timeout);
  line->recover();
  line->say("1;+9E1,+9E1,+9E1,+9E1,+9E1,+9E1,+9E1,+9E1\n");
  EXPECT_DOUBLE_EQ(bank->read()[0].value().value, 20.123);
}

TEST_F(TextThermometer, RejectsExchangedInstrumentAfterLostAnswer) {
  ASSERT_TRUE(bank->read()[0]);
  line->fall_silent();
  (void)bank->read();
  line->recover();
  instrument.identity = "HEWLETT-PACKARD,34970A,0,9-1-2";
  for (const auto& reading : bank->read()) EXPECT_FALSE(reading);
}

TEST_F(TextThermometer, OnlyAWholeAnswerIsAccepted) {
  for (const auto* garbage :
       {"1;+2.0E+01,+2.1E+01\n", "+2.0E+01,+2.0E+01,+2.0E+01,+2.0E+01,+2.0E+01,+2.0E+01,+2.0E+01,+2.0E+01\n",
        "1;2 C,2 C,2 C,2 C,2 C,2 C,2 C,2 C\n", "1;1,2,3,4,5,6,7,nan\n", "1;1,2,3,4,5,6,7,8,9\n", "\n"}) {
    auto made = std::make_unique<tests::FakeStream>();
    made->instrument = [this, garbage](std::string_view question) {
      return question.starts_with(kScan) ? std::string(garbage) : instrument.answer(std::string(question));
    };
    bank = make_text_thermometer(read_shipped("keysight_34970a"), std::move(made), "bank");
    expect_all(bank->read(), FaultKind::corrupted);
  }
}

/// A Lake Shore 336, with the format of the manual: a sign, three digits, a point, three digits, CR LF.
class TextThermometer336 : public testing::Test {
 protected:
  TextThermometer336() {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [this](std::string_view question) -> std::string {
      if (question == "*IDN?\r\n") return "LSCI,MODEL336,LSA22VS/#######,2.8\r\n";
      for (const auto& [input, reading] : readings) {
        if (question == fmt::format("CRDG? {}\r\n", input)) return reading + "\r\n";
        if (question == fmt::format("RDGST? {}\r\n", input)) return status[input] + "\r\n";
      }
      return "";
    };
    auto description = read_shipped("lakeshore_336");
    description.unit.link.text.after_read = {};
    bank = make_text_thermometer(std::move(description), std::move(made), "bank");
  }

  std::map<char, std::string> readings{{'A', "+020.123"}, {'B', "-040.250"}, {'C', "+000.000"}, {'D', "-273.150"}};
  std::map<char, std::string> status{{'A', "000"}, {'B', "000"}, {'C', "000"}, {'D', "128"}};
  tests::FakeStream* line{};
  std::unique_ptr<Thermometer> bank;
};

TEST_F(TextThermometer336, AsksReadingAndStatusOfEachInput) {
  const auto all = bank->read();
  ASSERT_EQ(all.size(), 4u);
  EXPECT_DOUBLE_EQ(all[0].value().value, 20.123);
  EXPECT_DOUBLE_EQ(all[1].value().value, -40.25);
  EXPECT_DOUBLE_EQ(all[2].value().value, 0);
  ASSERT_FALSE(all[3]);
  EXPECT_EQ(text(all[3].error()), "bank input 4: the instrument reports sensor_units_over_range (status 128)");
}

TEST_F(TextThermometer336, YieldsNoValueWithBadStatus) {
  for (const auto& [bits, flags] : std::map<std::string, std::string>{
           {"001", "invalid_reading"}, {"032", "over_range"}, {"080", "sensor_units_zero, under_range"}}) {
    status['B'] = bits;
    const auto all = bank->read();
    ASSERT_FALSE(all[1]);
    EXPECT_EQ(all[1].error().kind, FaultKind::out_of_range);
    EXPECT_NE(all[1].error().what.find(flags), std::string::npos) << all[1].error().what;
    EXPECT_TRUE(all[0]);
  }
}

TEST_F(TextThermometer336, ReportsFaultOfInputsAfterSilentOne) {
  ASSERT_TRUE(bank->read()[0]);
  readings.erase('C');
  const auto all = bank->read();
  ASSERT_EQ(all.size(), 4u);
  EXPECT_TRUE(all[0]);
  EXPECT_TRUE(all[1]);
  EXPECT_EQ(all[2].error().kind, FaultKind::timeout);
  EXPECT_EQ(all[3].error().kind, FaultKind::timeout);
}

TEST(TextThermometerFiles, LakeShore224AsksReadingAndStatusInOneLine) {
  auto description = read_shipped("lakeshore_224");
  description.unit.link.text.after_read = {};
  EXPECT_EQ(description.inputs, 12u);
  auto made = std::make_unique<tests::FakeStream>();
  auto* line = made.get();
  line->instrument = [](std::string_view question) -> std::string {
    if (question == "*IDN?\r\n") return "LSCI,MODEL224,LSA22VS,1.4\r\n";
    return question == "CRDG? C5;RDGST? C5\r\n" ? "+999.000;032\r\n" : "+021.500;000\r\n";
  };
  const auto bank = make_text_thermometer(std::move(description), std::move(made), "bank");
  const auto readings = bank->read();
  ASSERT_EQ(readings.size(), 12u);
  EXPECT_EQ(readings[11].value(), Celsius{21.5});
  EXPECT_EQ(readings[6].error().kind, FaultKind::out_of_range);
  EXPECT_EQ(line->heard.back(), "CRDG? D5;RDGST? D5\r\n");
}

TEST(TextThermometerFiles, KeithleysHaveThePublishedLines) {
  const auto lines_of = [](const ThermometerDescription& description) {
    std::set<std::string> lines;
    for (const auto& step : description.preparation) lines.insert(step.line);
    return lines;
  };
  const auto k2700 = read_shipped("keithley_2700");
  for (const auto* line : {"SENS:FUNC 'TEMP',(@101:108)", "SENS:TEMP:TRAN FRTD,(@101:108)",
                           "SENS:TEMP:FRTD:TYPE PT100,(@101:108)", "ROUT:SCAN:TSO IMM", "ROUT:SCAN:LSEL INT"})
    EXPECT_TRUE(lines_of(k2700).contains(line)) << line;
  EXPECT_TRUE(
      fits_expression(k2700.unit.identity->pattern, "KEITHLEY INSTRUMENTS INC.,MODEL 2700,1150720,B09  /A02  "));
  const auto daq = read_shipped("keithley_daq6510");
  for (const auto* line : {"SENS:FUNC \"TEMP\", (@101:108)", "SENS:TEMP:TRAN FRTD, (@101:108)",
                           "SENS:TEMP:RTD:FOUR PT100, (@101:108)", "ROUT:SCAN:CRE (@101:108)"})
    EXPECT_TRUE(lines_of(daq).contains(line)) << line;
  EXPECT_EQ(daq.readings.front().ask, "TRAC:CLE \"defbuffer1\";:INIT:IMM;*WAI;:TRAC:DATA? 1, 8, \"defbuffer1\", READ");
}

TEST(ThermometerDescriptions, EveryShippedFileIsValidForEditorsToo) {
  const std::string root = GYROTHERM_SOURCE_DIR;
  const auto command = "python3 " + root + "/tests/drivers/validate_descriptions.py " + root + "/profiles/thermometers";
  const int status = std::system(command.c_str());
  if (!WIFEXITED(status) || WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127)
    GTEST_SKIP() << "python3 with python3-jsonschema is not installed";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(ThermometerDescriptions, ParseExampleOfPage) {
  const auto page = read_text_file(GYROTHERM_SOURCE_DIR "/docs/text-instruments.md").value();
  const auto kind = page.find("kind = \"thermometer\"\nname = \"TS-2\"");
  ASSERT_NE(kind, std::string::npos);
  const auto first = page.find('\n', page.rfind("```toml", kind)) + 1;
  const auto description = parse_thermometer_description(page.substr(first, page.find("```", kind) - first), "page");
  ASSERT_TRUE(description) << text(description.error());
  EXPECT_EQ(description->preparation.size(), 2u);
  EXPECT_EQ(convert_reading(*description, 0, 23.5, 0).value(), Celsius{23.5});
  EXPECT_EQ(convert_reading(*description, 1, 9.9e37, 0).error().kind, FaultKind::out_of_range);
}

constexpr const char* kGood = R"(schema = "gyrotherm-text/1"
kind = "thermometer"
name = "T 8"
vendor = "Maker"
source = "a test"
[link.tcp]
port = 4001
[identity]
ask = "ID?"
[[item]]
name = "readings"
count = 2
ask = "T?"
answer = "{value:f*2,}"
unit = "°F"
range = [-100, 200]
)";

std::string trouble_with(const std::string& from, const std::string& to) {
  std::string text_of = kGood;
  const auto at = text_of.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text_of.replace(at, from.size(), to);
  const auto description = parse_thermometer_description(text_of, "file.toml");
  return description ? "" : text(description.error());
}

TEST(ThermometerDescriptions, ConvertUnits) {
  const auto description = parse_thermometer_description(kGood, "file.toml");
  ASSERT_TRUE(description) << text(description.error());
  EXPECT_NEAR(convert_reading(*description, 0, 212, 0).value().value, 100, 1e-9);
  EXPECT_NEAR(to_number(*description, {100}), 212, 1e-9);
  EXPECT_EQ(convert_reading(*description, 1, 500, 0).error().where, "input 2");
  EXPECT_EQ(describe_confidence(*description), "2 inputs: unverified");
}

TEST(ThermometerDescriptions, RefuseErrors) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& part) {
    const auto found = trouble_with(from, to);
    EXPECT_NE(found.find(part), std::string::npos) << to << ": " << found;
  };
  expect("f*2,", "f*3,", "not a list of 2 numbers");
  expect("{value:f*2,}", "{value:s}", "not a list of 2 numbers");
  expect("{value:f*2,}", "{_:f*2,}", "expected the field \"value\"");
  expect("{value:f*2,}", "{value:f*2,};{status:d*2,}", "needs an item of this name with \"flags\"");
  expect("{value:f*2,}", "{value:f*2,} {air:f}", "\"air\" has no meaning here");
  expect("range = [-100, 200]", "range = [200, -100]", "expected [lowest, highest]");
  expect("count = 2", "count = 65", "expected 1 to 64");
  for (const auto* unit : {"degF", "° F", "°f", "kelvin"})
    expect("unit = \"°F\"", "unit = \"" + std::string(unit) + "\"", "°F");
  expect("[link.tcp]\n", "[link.tcp]\nquestion_end = \"CR\"\n", "\"CR\" is two letters; write \"\\r\"");
  expect("count = 2\n", "", "expected one of \"count\" and \"inputs\"");
  expect("\"ID?\"", "\"ID?\"\npattern = \"(a|b)\"", "is not a regular expression without groups");
  expect("[[item]]", "[sequence]\nprepare = [{ tell = \"A {x:d}\" }]\n[[item]]", "the field \"x\" has no value here");
  expect("[[item]]", "[sequence]\nprepare = [{ ask = \"A?\" }]\n[[item]]", "missing key \"answer\"");
  expect("[[item]]", "[sequence]\nprepare = [{ ask = \"A?\", answer = \"{x:d}\", is = \"one\" }]\n[[item]]",
         "the field \"x\" is a number");
  expect("[[item]]", "[simulated]\nnumber = \"{}\"\n[[item]]", "expected a format such as");
  expect("[link.tcp]\n", "[link.tcp]\ntimeout = \"11 s\"\n", "\"timeout\" is 11 s, expected at most 10 s");
  expect("[link.tcp]\nport = 4001\n", "[link]\n", "expected [link.tcp] or [link.serial]");
  expect("kind = \"thermometer\"", "kind = \"chamber\"", "thermometer");
}

}  // namespace
}  // namespace gyrotherm::drivers
