// SPDX-License-Identifier: Apache-2.0
// The scripted supplies follow published lines, not the files of profiles/supplies.
#include "drivers/supply/power_supply.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

SupplyDescription read_shipped_supply(const std::string& name) {
  const auto file = GYROTHERM_SOURCE_DIR "/profiles/supplies/" + name + ".toml";
  auto description = parse_supply_description(read_text_file(file).value_or(""), file);
  EXPECT_TRUE(description) << text(description.error());
  return std::move(*description);
}

/// Returns the line without a prefix, or an empty text if it has another one.
std::string after_prefix(const std::string& line, const std::string& prefix) {
  return line.starts_with(prefix) ? line.substr(prefix.size()) : "";
}

/// Output 2 of an E36312A with a load of 48 Ω. Numbers have eight decimals and an exponent.
class ScriptedE36312A {
 public:
  std::string identity = "Keysight Technologies,E36312A,MY59001234,2.1.0-1.0.4-1.12";
  double voltage = 5, current = 0.1, over_voltage = 33;
  bool is_on = false, trips_at_limit = false, has_tripped = false;
  /// The panel ignores commands; the highest voltage that is accepted; numbers have a comma.
  bool is_locked = false, has_comma = false;
  double highest = 25;

  std::string answer(std::string line) {
    line = line.substr(0, line.find('\n'));
    if (line == "*IDN?") return identity + "\n";
    constexpr std::string_view kOutput = ",(@2)";
    if (line.ends_with(kOutput) && !line.ends_with("? (@2)"))
      return write(line.substr(0, line.size() - kOutput.size()));
    if (line == "OUTP:PROT:CLE (@2)") return has_tripped = false, "";
    if (line == "VOLT? (@2)") return number(voltage);
    if (line == "CURR? (@2)") return number(current);
    if (line == "VOLT:PROT? (@2)") return number(over_voltage);
    if (line == "CURR:PROT:STAT? (@2)") return trips_at_limit ? "1\n" : "0\n";
    if (line == "OUTP? (@2)") return is_on ? "1\n" : "0\n";
    if (line == "MEAS:VOLT? (@2)") return number(is_on ? voltage : 0.002);
    if (line == "MEAS:CURR? (@2)") return number(is_on ? std::min(voltage / 48, current) : 0.0001);
    if (line == "VOLT:PROT:TRIP? (@2)") return "0\n";
    if (line == "CURR:PROT:TRIP? (@2)") return has_tripped ? "1\n" : "0\n";
    return "";
  }

 private:
  [[nodiscard]] std::string number(double value) const {
    auto shown = fmt::format("{:+.8E}", value);
    if (has_comma) std::ranges::replace(shown, '.', ',');
    return shown + "\n";
  }
  std::string write(const std::string& line) {
    if (is_locked) return "";
    const auto set = [&](const char* command, double& value) {
      if (const auto number = after_prefix(line, command); !number.empty() && std::atof(number.c_str()) <= highest + 10)
        value = std::atof(number.c_str());
    };
    set("VOLT:PROT ", over_voltage);
    if (std::atof(after_prefix(line, "VOLT ").c_str()) <= highest) set("VOLT ", voltage);
    set("CURR ", current);
    if (line.starts_with("CURR:PROT:STAT ")) trips_at_limit = line.ends_with("1");
    if (line.starts_with("OUTP ")) is_on = line.ends_with("1") && !has_tripped;
    if (is_on && trips_at_limit && voltage / 48 > current) is_on = false, has_tripped = true;
    return "";
  }
};

class TextSupplyTest : public testing::Test {
 protected:
  TextSupplyTest() {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [this](std::string_view question) { return instrument.answer(std::string(question)); };
    supply = make_text_supply(
        read_shipped_supply("keysight_e36312a"),
        {{.output = 1, .voltage_v = 24, .current_a = 0.6, .over_voltage_v = 26, .over_current_a = 0.6}},
        std::move(made), "supply 1");
  }
  /// Returns the commands that were sent, without the questions.
  [[nodiscard]] std::vector<std::string> commands() const {
    std::vector<std::string> all;
    for (const auto& one : line->heard)
      if (one.find('?') == std::string::npos) all.push_back(one.substr(0, one.find('\n')));
    return all;
  }
  SupplyReadings switch_to(PowerDemand demand) {
    supply->demand(demand);
    return supply->read();
  }

  ScriptedE36312A instrument;
  tests::FakeStream* line{};
  std::unique_ptr<PowerSupply> supply;
};

TEST_F(TextSupplyTest, WritesLimitsFirstAndSwitchesOnLast) {
  const auto readings = switch_to(PowerDemand::on);
  EXPECT_EQ(readings.pending, PowerDemand::keep) << readings.trouble;
  EXPECT_EQ(commands(), (std::vector<std::string>{"VOLT:PROT 26.000,(@2)", "CURR:PROT:STAT 1,(@2)", "VOLT 24.000,(@2)",
                                                  "CURR 0.600,(@2)", "OUTP 1,(@2)"}));
  ASSERT_TRUE(readings.outputs.at(0));
  EXPECT_TRUE(readings.outputs[0]->is_on);
  EXPECT_DOUBLE_EQ(readings.outputs[0]->voltage_v, 24);
  EXPECT_DOUBLE_EQ(readings.outputs[0]->current_a, 0.5);
  EXPECT_EQ(line->heard.front(), "*IDN?\n");
}

TEST_F(TextSupplyTest, OffIsNeverZeroVolts) {
  (void)switch_to(PowerDemand::on);
  line->heard.clear();
  const auto readings = switch_to(PowerDemand::off);
  EXPECT_EQ(readings.pending, PowerDemand::keep) << readings.trouble;
  EXPECT_EQ(commands(), std::vector<std::string>{"OUTP 0,(@2)"});
  EXPECT_FALSE(readings.outputs.at(0)->is_on);
}

TEST_F(TextSupplyTest, LeavesALiveOutputWithTheRightSettingsAlone) {
  (void)switch_to(PowerDemand::on);
  line->heard.clear();
  EXPECT_EQ(switch_to(PowerDemand::on).pending, PowerDemand::keep);
  EXPECT_EQ(commands(), std::vector<std::string>{});
}

TEST_F(TextSupplyTest, ChangesNothingOnALiveOutputWithOtherSettings) {
  instrument.is_on = true;
  const auto readings = switch_to(PowerDemand::on);
  EXPECT_EQ(readings.pending, PowerDemand::on);
  EXPECT_NE(readings.trouble.find("voltage is 5 V instead of 24 V"), std::string::npos) << readings.trouble;
  EXPECT_EQ(commands(), std::vector<std::string>{});
  EXPECT_TRUE(supply->inspect().at(0)->difference.find("voltage is 5 V") != std::string::npos);
}

TEST_F(TextSupplyTest, ReadsBackEachSettingBeforeSwitchingOn) {
  instrument.highest = 20;
  const auto readings = switch_to(PowerDemand::on);
  EXPECT_EQ(readings.pending, PowerDemand::on);
  EXPECT_NE(readings.trouble.find("voltage is 5 V instead of 24 V after it was written"), std::string::npos)
      << readings.trouble;
  EXPECT_FALSE(instrument.is_on);
  instrument.highest = 25;
  EXPECT_EQ(supply->read().pending, PowerDemand::keep) << "it is tried again each second";
  EXPECT_TRUE(instrument.is_on);
}

TEST_F(TextSupplyTest, ReportsAnOutputThatDoesNotSwitch) {
  (void)switch_to(PowerDemand::on);
  instrument.is_locked = true;
  const auto readings = switch_to(PowerDemand::off);
  EXPECT_EQ(readings.pending, PowerDemand::off);
  EXPECT_NE(readings.trouble.find("it is on although it was switched off"), std::string::npos) << readings.trouble;
}

TEST_F(TextSupplyTest, DoesNotRepeatASwitchAfterATrip) {
  instrument.has_tripped = true;
  auto readings = switch_to(PowerDemand::on);
  EXPECT_TRUE(readings.gave_up);
  EXPECT_EQ(readings.outputs.at(0)->trips, std::vector<std::string>{"over_current"});
  readings = supply->read();
  EXPECT_TRUE(readings.gave_up);
  EXPECT_EQ(commands(), std::vector<std::string>{});
  readings = switch_to(PowerDemand::on_after_trip);
  EXPECT_EQ(readings.pending, PowerDemand::keep) << readings.trouble;
  EXPECT_EQ(commands().front(), "OUTP:PROT:CLE (@2)");
  EXPECT_TRUE(instrument.is_on);
}

TEST_F(TextSupplyTest, ClearsTripsOfAllOutputsAndRepeatsClearThatFailed) {
  ScriptedE36312A first;
  first.has_tripped = instrument.has_tripped = true;
  auto made = std::make_unique<tests::FakeStream>();
  int clears = 0;
  made->instrument = [&](std::string_view question) {
    std::string text(question);
    if (text.starts_with("OUTP:PROT:CLE") && clears++ == 0) return std::string();  // lost
    const auto at = text.find("(@1)");
    if (at == std::string::npos) return instrument.answer(text);
    return first.answer(text.replace(at, 4, "(@2)"));
  };
  const std::vector<OutputSettings> outputs = {{.output = 0, .voltage_v = 24, .current_a = 0.6, .over_current_a = 0.6},
                                               {.output = 1, .voltage_v = 24, .current_a = 0.6, .over_current_a = 0.6}};
  supply = make_text_supply(read_shipped_supply("keysight_e36312a"), outputs, std::move(made), "supply 1");
  EXPECT_TRUE(switch_to(PowerDemand::on).gave_up);
  EXPECT_TRUE(switch_to(PowerDemand::on_after_trip).gave_up) << "the first command was lost";
  const auto readings = switch_to(PowerDemand::on_after_trip);
  EXPECT_EQ(readings.pending, PowerDemand::keep) << readings.trouble;
  EXPECT_TRUE(first.is_on && instrument.is_on);
}

TEST_F(TextSupplyTest, GivesUpWhenTheOutputTripsAtOnce) {
  supply = nullptr;
  auto made = std::make_unique<tests::FakeStream>();
  made->instrument = [this](std::string_view question) { return instrument.answer(std::string(question)); };
  supply = make_text_supply(read_shipped_supply("keysight_e36312a"),
                            {{.output = 1, .voltage_v = 24, .current_a = 0.4, .over_current_a = 0.4}}, std::move(made),
                            "supply 1");
  const auto readings = switch_to(PowerDemand::on);
  EXPECT_TRUE(readings.gave_up);
  EXPECT_NE(readings.trouble.find("has tripped (over_current)"), std::string::npos) << readings.trouble;
}

TEST_F(TextSupplyTest, AnotherInstrumentIsNeverSwitched) {
  instrument.identity = "RIGOL TECHNOLOGIES,DP832A,DP8B1,00.01.16";
  const auto readings = switch_to(PowerDemand::on);
  EXPECT_EQ(readings.outputs.at(0).error().kind, FaultKind::mismatch);
  EXPECT_EQ(readings.pending, PowerDemand::on);
  EXPECT_EQ(commands(), std::vector<std::string>{});
}

TEST_F(TextSupplyTest, RejectsCommaAsDecimalMark) {
  instrument.has_comma = true;
  const auto readings = switch_to(PowerDemand::on);
  EXPECT_EQ(readings.outputs.at(0).error().kind, FaultKind::corrupted);
  EXPECT_EQ(readings.pending, PowerDemand::on);
  EXPECT_FALSE(instrument.is_on);
}

TEST_F(TextSupplyTest, RejectsLateAnswer) {
  (void)switch_to(PowerDemand::on);
  line->answer_late();
  for (int i = 0; i < 5; ++i) {
    const auto readings = supply->read();
    if (!readings.outputs.at(0)) continue;
    EXPECT_DOUBLE_EQ(readings.outputs[0]->voltage_v, 24) << "an answer to another question";
  }
  line->recover();
}

TEST_F(TextSupplyTest, KeepsDemandWhenSupplyIsSilent) {
  line->fall_silent();
  auto readings = switch_to(PowerDemand::on);
  EXPECT_EQ(readings.outputs.at(0).error().kind, FaultKind::timeout);
  EXPECT_EQ(readings.pending, PowerDemand::on);
}

/// A CPX400DP: answers with a unit letter or the echoed name; LSR1? shows the state at the previous question.
TEST(TtiSupply, AcceptsUnitLettersAndAsksForTripsTwice) {
  double voltage = 1, current = 1, over_voltage = 44, over_current = 22;
  bool is_on = false, tripped = false;
  int shown = 0;
  auto made = std::make_unique<tests::FakeStream>();
  auto* line = made.get();
  line->instrument = [&](std::string_view sent) -> std::string {
    std::string question(sent.substr(0, sent.find("\r\n")));
    const auto set = [&](const char* command, double& value) {
      const auto number = after_prefix(question, command);
      if (!number.empty()) value = std::atof(number.c_str());
      return !number.empty();
    };
    if (question == "*IDN?") return "THURLBY THANDAR, CPX400DP, 123456, 1.02-1.00\r\n";
    if (question == "V1?") return fmt::format("V1 {:.3f}\r\n", voltage);
    if (question == "I1?") return fmt::format("I1 {:.4f}\r\n", current);
    if (question == "OVP1?") return fmt::format("VP1 {:.2f}\r\n", over_voltage);
    if (question == "OCP1?") return fmt::format("CP1 {:.2f}\r\n", over_current);
    if (question == "OP1?") return is_on ? "1\r\n" : "0\r\n";
    if (question == "V1O?") return fmt::format("{:.3f}V\r\n", is_on ? voltage : 0);
    if (question == "I1O?") return fmt::format("{:.4f}A\r\n", is_on ? voltage / 48 : 0);
    if (question == "LSR1?") return fmt::format("{}\r\n", std::exchange(shown, tripped ? 8 : 1));
    if (!question.ends_with(";*OPC?")) return "";
    if (question.starts_with("OP1 ")) is_on = question[4] == '1';
    if (!set("OVP1 ", over_voltage) && !set("OCP1 ", over_current) && !set("V1 ", voltage)) set("I1 ", current);
    return "1\r\n";
  };
  const auto supply =
      make_text_supply(read_shipped_supply("tti"),
                       {{.output = 0, .voltage_v = 24, .current_a = 1, .over_voltage_v = 26, .over_current_a = 1.2}},
                       std::move(made), "supply 1");
  supply->demand(PowerDemand::on);
  auto readings = supply->read();
  EXPECT_EQ(readings.pending, PowerDemand::keep) << readings.trouble;
  EXPECT_DOUBLE_EQ(readings.outputs.at(0)->voltage_v, 24);
  tripped = true;
  is_on = false;
  readings = supply->read();
  EXPECT_EQ(readings.outputs.at(0)->trips, std::vector<std::string>{"over_current"});
}

/// The two answers about a trip that models of the DP800 and DP900 give.
TEST(RigolSupply, AcceptsBothFormsOfATrip) {
  for (const auto* form : {"YES", "1"}) {
    auto made = std::make_unique<tests::FakeStream>();
    made->instrument = [&](std::string_view sent) -> std::string {
      const std::string question(sent.substr(0, sent.find('\n')));
      if (question == "*IDN?") return "RIGOL TECHNOLOGIES,DP832A,DP8B123456789,00.01.16\n";
      if (question == ":OUTP? CH1") return "OFF\n";
      if (question == ":MEAS:ALL? CH1") return "5.0114,0.0000,0.000\n";
      if (question == ":OUTP:OVP:QUES? CH1") return std::string(form) + "\n";
      if (question == ":OUTP:OCP:QUES? CH1") return std::string(form) == "1" ? "0\n" : "NO\n";
      return "";
    };
    const auto supply = make_text_supply(read_shipped_supply("rigol_dp800"),
                                         {{.output = 0, .voltage_v = 5, .current_a = 1}}, std::move(made), "supply");
    const auto readings = supply->read();
    ASSERT_TRUE(readings.outputs.at(0)) << text(readings.outputs[0].error());
    EXPECT_DOUBLE_EQ(readings.outputs[0]->voltage_v, 5.0114);
    EXPECT_EQ(readings.outputs[0]->trips, std::vector<std::string>{"over_voltage"}) << form;
  }
}

TEST(SupplyDescription, EveryShippedFileIsReadAndDescribed) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/supplies")) {
    if (entry.path().extension() != ".toml") continue;
    const auto description = read_shipped_supply(entry.path().stem());
    EXPECT_FALSE(description.simulated.identity.empty()) << entry.path();
    EXPECT_NE(describe_confidence(description).find("output"), std::string::npos);
    ++files;
  }
  EXPECT_EQ(files, 6);
}

TEST(SupplyDescription, EveryShippedFileIsValidForEditorsToo) {
  const std::string root = GYROTHERM_SOURCE_DIR;
  const auto command = "python3 " + root + "/tests/drivers/validate_descriptions.py " + root + "/profiles/supplies";
  const int status = std::system(command.c_str());
  if (!WIFEXITED(status) || WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127)
    GTEST_SKIP() << "python3 with python3-jsonschema is not installed";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(SupplyDescription, EachSelectsTheOutputInTheLineItself) {
  const auto hmp = read_shipped_supply("rs_hmp");
  for (std::size_t i = 0; i < hmp.outputs.size(); ++i)
    for (const auto& question : hmp.outputs[i].questions)
      EXPECT_TRUE(question.ask.starts_with(fmt::format("INST:NSEL {};:", i + 1))) << question.ask;
}

TEST(SupplyDescription, RefusesErrorsWithTheirPositions) {
  const auto path = GYROTHERM_SOURCE_DIR "/profiles/supplies/tti.toml";
  const auto whole = read_text_file(path).value();
  const auto error = [&](const std::string& from, const std::string& to) {
    auto edited = whole;
    edited.replace(edited.find(from), from.size(), to);
    const auto description = parse_supply_description(edited, "tti.toml");
    return description ? std::string() : text(description.error());
  };
  EXPECT_NE(error("name = \"voltage\"", "name = \"volts\"").find("tti.toml:"), std::string::npos);
  EXPECT_NE(error("codes = { off = \"0\", on = \"1\" }", "").find("\"output\" needs \"codes\""), std::string::npos);
  EXPECT_NE(error("outputs = 2", "outputs = 9").find("outputs"), std::string::npos);
  EXPECT_NE(error("tell = \"V{output:d} {value:f.3};*OPC?\"", "tell = \"V{output:d}\"").find("\"value\" is missing"),
            std::string::npos);
  EXPECT_NE(error("timeout = \"1 s\"", "timeout = \"5 s\"").find("expected at most 4 s"), std::string::npos);
  EXPECT_NE(error("flags = {", "unknown = {").find("tti.toml:"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::drivers
