// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm describe` for text instruments of every kind, and its questions to an instrument.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/apps/gyrotherm/program.hpp"
#include "tests/support/loopback_server.hpp"

namespace gyrotherm::app {
namespace {

/// An electronic load: a kind without a reader of its own.
constexpr const char* kLoad = R"(schema = "gyrotherm-text/1"
kind = "load"
name = "PS-1"
vendor = "Acme"
source = "a test"
[link]
question_end = "\n"
answer_end = "\n"
timeout = "500 ms"
refused = "ERR {code:d}"
refusals = { 2 = "remote control is off" }
[link.tcp]
port = 5025
[parameter]
output = 1
[identity]
ask = "*IDN?"
pattern = "PS-1"
[[item]]
name = "voltage"
ask = "MEAS:VOLT? {output:d}"
answer = "{value:f}"
unit = "V"
highest_output = "a key of its own kind"
confidence = "manual"
[[item]]
name = "state"
ask = "OUTP? {output:d}"
answer = "{value:d}"
codes = { off = 0, on = 1 }
[[item]]
name = "set_voltage"
tell = "VOLT {output:d},{value:f.3}"
acknowledged = "OK"
[[item]]
name = "current"
before = "RANGE AUTO"
ask = "MEAS:CURR? {output:d}"
answer = "{value:f}"
[rules]
of_its_own = true
)";

/// Answers lines on the loopback interface as the map states; an unknown line is not answered.
class Instrument {
 public:
  explicit Instrument(std::map<std::string, std::string> answers)
      : answers_(std::move(answers)),
        server_([this](std::span<const std::byte> request) { return drivers::Answer{.bytes = answer(request)}; }) {}

  [[nodiscard]] std::string line() const { return fmt::format("tcp://127.0.0.1:{}", server_.address().port); }
  [[nodiscard]] std::vector<std::string> heard() const {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

 private:
  /// Takes the complete lines and returns their answers.
  std::vector<std::byte> answer(std::span<const std::byte> request) {
    const std::lock_guard lock(mutex_);
    for (const auto byte : request) received_.push_back(static_cast<char>(byte));
    std::vector<std::byte> reply;
    for (auto end = received_.find('\n'); end != std::string::npos; end = received_.find('\n')) {
      heard_.push_back(received_.substr(0, received_.find_first_of("\r\n")));
      received_.erase(0, end + 1);
      const auto found = answers_.find(heard_.back());
      if (found == answers_.end()) continue;
      std::ranges::transform(found->second + "\n", std::back_inserter(reply),
                             [](char character) { return static_cast<std::byte>(character); });
    }
    return reply;
  }

  mutable std::mutex mutex_;
  std::map<std::string, std::string> answers_;
  std::string received_;
  std::vector<std::string> heard_;
  drivers::LoopbackServer server_;  ///< declared last: uses all members above
};

TEST(Describe, ListsLinesOfAnyKind) {
  const Folder folder;
  std::ofstream(folder / "load.toml") << kLoad;
  const auto ran = gyrotherm_with("describe --parameter output=2 " + (folder / "load.toml"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* expected :
       {"Acme PS-1", "parameter output = 2", "MEAS:VOLT? 2 ", "OUTP? 2 ", "VOLT 2,… ", "writes set_voltage",
        "RANGE AUTO", "precedes the next question", "items: 1 manual, 4 unverified"})
    EXPECT_NE(ran.out.find(expected), std::string::npos) << expected << "\n" << ran.out;
  const auto scanner =
      gyrotherm_with("describe keysight_34970a --parameter channel_count=3 --parameter channels=201:203");
  ASSERT_EQ(scanner.exit_code, 0) << scanner.err;
  for (const auto* expected :
       {"ROUT:SCAN (@201:203)", "readings_1, readings_2, readings_3", "3 inputs: manual", "prepares, and is answered"})
    EXPECT_NE(scanner.out.find(expected), std::string::npos) << expected << "\n" << scanner.out;
  EXPECT_NE(gyrotherm_with("describe lakeshore_336").out.find("readings_A"), std::string::npos);
}

TEST(Describe, ListsLinesOfOutputOfEveryShippedSupply) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/supplies")) {
    if (entry.path().extension() != ".toml") continue;
    const auto name = entry.path().stem().string();
    SCOPED_TRACE(name);
    ++count;
    const auto first = gyrotherm_with("describe " + name);
    EXPECT_EQ(first.exit_code, 0) << first.err;
    EXPECT_NE(first.out.find("measured_voltage"), std::string::npos) << first.out;
    EXPECT_NE(first.out.find(" output"), std::string::npos) << first.out;
    const auto unknown = gyrotherm_with("describe " + name + " --parameter outputs=2");
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_NE(unknown.err.find("has no parameter \"outputs\", expected one of: output"), std::string::npos)
        << unknown.err;
  }
  EXPECT_GE(count, 6);
  const auto second = gyrotherm_with("describe tti --parameter output=2");
  EXPECT_NE(second.out.find("OVP2? "), std::string::npos) << second.out << second.err;
  EXPECT_EQ(second.out.find("OVP1"), std::string::npos);
}

TEST(Describe, RefusesErrorsWithTheirPosition) {
  const Folder folder;
  std::string wrong = kLoad;
  wrong.replace(wrong.find("{value:f}"), 9, "{value:z}");
  std::ofstream(folder / "wrong.toml") << wrong;
  const auto ran = gyrotherm_with("describe " + (folder / "wrong.toml"));
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("wrong.toml:22:"), std::string::npos) << ran.err;
  for (const auto& [arguments, expected] :
       std::map<std::string, std::string>{{"keysight_34970a --parameter chanels=1", "has no parameter \"chanels\""},
                                          {"keysight_34970a --parameter channels", "is not NAME=VALUE"},
                                          {"watlow_f4t", "is not"},
                                          {"profiles/rigs/virtual.toml", "is not the file of a text instrument"}}) {
    const auto refused = gyrotherm_with("describe " + arguments);
    EXPECT_EQ(refused.exit_code, 2) << arguments;
    EXPECT_NE(refused.err.find(expected), std::string::npos) << refused.err;
  }
}

/// A chamber whose commands repeat present values, and whose status is a text.
constexpr const char* kChamber = R"(schema = "gyrotherm-text/1"
kind = "chamber"
name = "C-1"
vendor = "Acme"
source = "a test"
[link]
question_end = "\n"
answer_end = "\n"
timeout = "500 ms"
[link.tcp]
port = 5025
[identity]
ask = "ID?"
pattern = "^C-1"
[[item]]
name = "air_temperature"
ask = "T?"
answer = "{value:f.1}"
[[item]]
name = "set_point"
ask = "S?"
answer = "{value:x4},{run:b1}"
tell = "W{value:x4}M{run:b1}F{fan:d}"
acknowledged = "OK"
scale = 0.1
[[item]]
name = "fan"
ask = "F?"
answer = "{value:d}"
tell = "W{set_point:x4}F{value:d}"
acknowledged = "OK"
[[item]]
name = "mode"
ask = "M?"
answer = "{value:s}"
codes = { off = "AUS", on = "EIN" }
[simulated]
initial = [{ item = "identity", text = "C-1 V1" }]
)";

/// Writes the chamber with a replacement to a file. Returns the path.
std::string write_chamber(const Folder& folder, const std::string& from = "", const std::string& to = "") {
  std::string text = kChamber;
  if (!from.empty()) text.replace(text.find(from), from.size(), to);
  std::ofstream(folder / "chamber.toml") << text;
  return folder / "chamber.toml";
}

TEST(Describe, ListsFieldsOfCommandsThatRepeatValues) {
  const Folder folder;
  const auto ran = gyrotherm_with("describe " + write_chamber(folder));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* expected : {"W…M?F… ", "W…F… "})
    EXPECT_NE(ran.out.find(expected), std::string::npos) << expected << "\n" << ran.out;
  EXPECT_NE(gyrotherm_with("describe weiss_ascii2").out.find("E … … …"), std::string::npos);
}

TEST(Describe, RefusesMistakesInVirtualChamberAndKind) {
  for (const auto& [from, to, expected] : std::vector<std::tuple<std::string, std::string, std::string>>{
           {"initial = [", "initially = [", "initially"},
           {"item = \"identity\", text = \"C-1 V1\"", "item = \"fan\", value = \"fast\"", "value"},
           {"text = \"C-1 V1\"", "text = \"D-1\"", "does not fit the pattern \"^C-1\""},
           {"kind = \"chamber\"\n", "", "missing key \"kind\""}}) {
    const Folder folder;
    const auto refused = gyrotherm_with("describe " + write_chamber(folder, from, to));
    EXPECT_EQ(refused.exit_code, 4) << to;
    EXPECT_NE(refused.err.find(expected), std::string::npos) << to << ": " << refused.err;
  }
}

TEST(Describe, ShowsTextWithoutCode) {
  const Folder folder;
  const auto file = write_chamber(folder);
  const Instrument chamber({{"ID?", "C-1 V1"}, {"M?", "OFF"}, {"T?", "T?\r 20.5"}});
  const auto talk = [&](const std::string& item) {
    return gyrotherm_with("describe " + file + " --talk " + chamber.line() + " --item " + item);
  };
  EXPECT_NE(talk("mode").out.find("\"OFF\" (no name in codes)"), std::string::npos) << talk("mode").out;
  EXPECT_NE(talk("air_temperature").err.find("repeats the question"), std::string::npos);
}

TEST(Describe, AsksInstrumentOfAnyKind) {
  const Folder folder;
  std::ofstream(folder / "load.toml") << kLoad;
  Instrument supply({{"MEAS:VOLT? 1", "11.97"}, {"OUTP? 1", "1"}, {"MEAS:VOLT? 2", "ERR 2"}});
  const auto talk = "describe " + (folder / "load.toml") + " --talk " + supply.line();
  const auto voltage = gyrotherm_with(talk + " --item voltage");
  EXPECT_EQ(voltage.exit_code, 0) << voltage.err;
  EXPECT_NE(voltage.out.find("voltage              11.97\n"), std::string::npos) << voltage.out;
  EXPECT_NE(gyrotherm_with(talk + " --item state").out.find("state                on\n"), std::string::npos);
  const auto refused = gyrotherm_with(talk + " --item voltage --parameter output=2");
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_NE(refused.err.find("remote control is off (2)"), std::string::npos) << refused.err;
  EXPECT_EQ(gyrotherm_with(talk + " --prepare").exit_code, 2) << "there is nothing to prepare";
  EXPECT_EQ(gyrotherm_with(talk + " --item set_voltage").exit_code, 2) << "no question reads it";
  EXPECT_EQ(supply.heard(), (std::vector<std::string>{"MEAS:VOLT? 1", "OUTP? 1", "MEAS:VOLT? 2"}));
}

TEST(Describe, TalksOverLineThatEchoes) {
  const Folder folder;
  std::ofstream(folder / "supply.toml") << kLoad;
  Instrument supply({{"OUTP? 1", "OUTP? 1\n1"}});
  const auto talk = "describe " + (folder / "supply.toml") + " --item state --talk " + supply.line();
  const auto without = gyrotherm_with(talk);
  EXPECT_EQ(without.exit_code, 3) << without.out;
  EXPECT_NE(without.err.find("the line repeats the question \"OUTP? 1\""), std::string::npos) << without.err;
  const auto with = gyrotherm_with(talk + " --echo");
  EXPECT_EQ(with.exit_code, 0) << with.err;
  EXPECT_NE(with.out.find("state                on\n"), std::string::npos) << with.out;
}

TEST(Describe, PreparesAndReadsScanner) {
  Instrument scanner({{"SYST:ERR?", "+0,\"No error\""}, {"INIT;*OPC?;FETC?", "1;+2.35E+01,+9.90000000E+37"}});
  const std::string talk = "describe keysight_34970a --parameter channels=101:102 --parameter channel_count=2 --talk " +
                           scanner.line() + " --item readings";
  const auto prepared = gyrotherm_with(talk + " --prepare");
  EXPECT_EQ(prepared.exit_code, 0) << prepared.err << prepared.out;
  EXPECT_NE(prepared.out.find("readings_1           23.5\n"), std::string::npos) << prepared.out;
  EXPECT_NE(prepared.out.find("readings_2           "), std::string::npos) << prepared.out;
  const auto heard = scanner.heard();
  ASSERT_GE(heard.size(), 5U);
  EXPECT_EQ(heard.front(), "ABOR");
  EXPECT_EQ(heard.back(), "INIT;*OPC?;FETC?");
  EXPECT_EQ(gyrotherm_with(talk).exit_code, 0);
  EXPECT_EQ(scanner.heard().size(), heard.size() + 1) << "without --prepare only the question is sent";
}

TEST(Describe, AsksEachInput) {
  Instrument lakeshore(
      {{"CRDG? A", "+21.00\r"}, {"CRDG? B", "+23.50\r"}, {"CRDG? C", "+0.00\r"}, {"CRDG? D", "+0.00\r"}});
  const auto talk = "describe lakeshore_336 --talk " + lakeshore.line() + " --item ";
  const auto one = gyrotherm_with(talk + "readings_B");
  EXPECT_NE(one.out.find("readings_B           23.5\n"), std::string::npos) << one.out << one.err;
  EXPECT_EQ(gyrotherm_with(talk + "readings").exit_code, 0);
  EXPECT_EQ(lakeshore.heard(), (std::vector<std::string>{"CRDG? B", "CRDG? A", "CRDG? B", "CRDG? C", "CRDG? D"}));
}

TEST(Describe, NamesLineThatCannotBeOpened) {
  const auto ran = gyrotherm_with("describe lakeshore_336 --talk tcp://127.0.0.1:9 --item readings");
  EXPECT_EQ(ran.exit_code, 3);
  EXPECT_EQ(ran.out, "") << "nothing was exchanged";
  EXPECT_NE(ran.err.find(" at tcp://127.0.0.1:9: "), std::string::npos) << ran.err;
}

}  // namespace
}  // namespace gyrotherm::app
