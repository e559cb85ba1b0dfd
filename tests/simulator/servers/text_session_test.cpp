// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "simulator/chamber_registers.hpp"
#include "simulator/servers/text_server.hpp"
#include "tests/simulator/servers/asking.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

/// The mode is in the answers of two questions, and is shown a minute after it was written.
constexpr const char* kMap = R"(schema = "gyrotherm-text/1"
kind = "chamber"
name = "C"
vendor = "Maker"
source = "a test"
[link]
question_end = "\n"
answer_end = "\n"
[link.tcp]
port = 10001
[[item]]
name = "mode"
ask = "MODE?"
answer = "{value:s}"
tell = "MODE,{value:s}"
acknowledged = "OK"
codes = { off = "OFF", on = "ON" }
[[item]]
name = "monitor"
ask = "MON?"
answer = "{air_temperature:f.1},{set_point:f.1},{mode:s}"
[[item]]
name = "set_point"
tell = "TEMP,{value:f.1}"
acknowledged = "OK"
[control]
commanded = "mode"
[simulated]
lag = "60 s"
)";

TEST(TextSession, LagAppliesToAnItemInTheAnswerOfAnotherQuestion) {
  const auto map = drivers::parse_register_map(kMap, "test").value();
  VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  ChamberRegisters unit(map, laboratory);
  const auto lagging = make_text_session(unit, drivers::LinkKind::text_tcp, true);
  EXPECT_EQ(ask(*lagging, "MODE,ON\n"), "OK\n");
  EXPECT_EQ(ask(*lagging, "MODE?\n"), "OFF\n");
  EXPECT_TRUE(ask(*lagging, "MON?\n").ends_with(",OFF\n"));
  const auto prompt = make_text_session(unit, drivers::LinkKind::text_tcp, false);
  EXPECT_EQ(ask(*prompt, "MODE?\n"), "ON\n");
  EXPECT_TRUE(ask(*prompt, "MON?\n").ends_with(",ON\n"));
}

/// Returns the errors of the table [simulated] of the map above.
std::string simulated_errors(const std::string& table) {
  std::string text_of = kMap;
  text_of.replace(text_of.find("lag = "), std::string::npos, table);
  const auto identity = std::string("[identity]\nask = \"ID?\"\npattern = \"C\"\n");
  text_of.insert(text_of.find("[[item]]"), identity);
  const auto map = drivers::parse_register_map(text_of, "c.toml");
  EXPECT_TRUE(map) << text(map.error());
  const auto unit = read_simulated_unit(*map, "c.toml");
  return unit ? std::string() : text(unit.error());
}

TEST(SimulatedTable, RefusesMistakes) {
  for (const auto& [table, part] :
       {std::pair("lag = \"x\"", "duration"), std::pair("lag = 5", "duration"), std::pair("unknown = 5", "unknown"),
        std::pair("unknown = \"°\"", "not a character of the encoding ascii"),
        std::pair("refuses = [{ item = \"set_point\" }]", "with"),
        std::pair("refuses = [{ item = \"set_pont\", with = \"NO\" }]", "no item is named \"set_pont\""),
        std::pair("turn_on = [{ item = \"mode\", is = \"on\" }]", "turn_on"),
        std::pair("turns_on = [{ item = \"mode\", is = \"yes\" }]", "yes"),
        std::pair("initial = [{ item = \"mod\", value = 1 }]", "no item is named \"mod\""),
        std::pair("initial = [{ item = \"set_point\", value = \"cold\" }]", "value"),
        std::pair("initial = [{ item = \"set_point\", text = \"cold\" }]", "is not a text"),
        std::pair("initial = [{ item = \"set_point\" }]", "value"),
        std::pair("initial = [{ item = \"mode\", code = \"x\" }]", "has no code named \"x\"; expected one of: off, on"),
        std::pair("initial = [{ item = \"identity\", value = 4 }]", "\"identity\" is a text, expected \"text\""),
        std::pair("initial = [{ item = \"identity\", text = 5 }]", "text"),
        std::pair("shows = [{ item = \"mode\", of = 0 }]", "of"),
        std::pair("shows = [{ item = \"mode\", on = \"run\" }]", "has no code named \"run\"; expected one of: off, on"),
        std::pair("program_number = \"number\"", "no item is named \"number\"")})
    EXPECT_NE(simulated_errors(table).find(part), std::string::npos) << table << ": " << simulated_errors(table);
  for (const auto* good : {"lag = \"1 s\"", "unknown = \"ERR\"", "refuses = [{ item = \"set_point\", with = \"NO\" }]",
                           "initial = [{ item = \"mode\", code = \"on\" }, { item = \"identity\", text = \"C 1\" }]",
                           "shows = [{ item = \"mode\", off = \"off\", on = \"on\" }]"})
    EXPECT_EQ(simulated_errors(good), "") << good;
}

TEST(SimulatedIdentity, FitsPatternOrIsRefused) {
  const auto map_with = [](const std::string& pattern) {
    std::string text_of = kMap;
    text_of.insert(text_of.find("[[item]]"), "[identity]\nask = \"ID?\"\npattern = '" + pattern + "'\n");
    return drivers::parse_register_map(text_of, "c.toml").value();
  };
  VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  for (const auto* pattern :
       {"^RIC40", "RIC40$", "^C-[0-9]+ V\\d\\.\\d{2}$", "A|B", "^[^0-9]x?y*z+$", "TYPE.*[45]", "^\\w+,C 1,", "C{3}"}) {
    const auto map = map_with(pattern);
    EXPECT_TRUE(check_simulated_identity(map, {}, "c.toml")) << pattern;
    ChamberRegisters unit(map, laboratory);
    const auto session = make_text_session(unit, drivers::LinkKind::text_tcp, false);
    auto answer = ask(*session, "ID?\n");
    ASSERT_TRUE(answer.ends_with("\n")) << pattern;
    answer.pop_back();
    EXPECT_TRUE(drivers::fits_expression(pattern, answer)) << pattern << ": " << answer;
  }
  EXPECT_FALSE(check_simulated_identity(map_with("^a\\bb"), {}, "c.toml")) << "no text fits";
  SimulatedUnit stated;
  stated.initial_texts = {{"identity", "RIC 41"}};
  EXPECT_TRUE(check_simulated_identity(map_with("^RIC 4"), stated, "c.toml"));
  const auto other = check_simulated_identity(map_with("^RIC40"), stated, "c.toml");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().what.find("\"RIC 41\" of \"identity\" does not fit the pattern \"^RIC40\""),
            std::string::npos)
      << other.error().what;
}

TEST(TextSession, RefusesPartsOfProgramsThatItDoesNotHave) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  ChamberRegisters unit(chamber_map("espec_p300"), laboratory);
  const auto session = make_text_session(unit, drivers::LinkKind::text_tcp, false);
  EXPECT_EQ(ask(*session, "PRGM DATA?,RAM:1,STEP1\r\n"), "NA:CMD ERR\r\n");
  const auto step = [&](const std::string& number, const std::string& kind) {
    return ask(*session, "PRGM DATA WRITE, PGM1, STEP" + number + ", TEMP25.0, TRAMP" + kind +
                             ", TIME0:05, GRANTY OFF, PAUSE OFF\r\n");
  };
  EXPECT_TRUE(step("1", "OFF").starts_with("OK:PRGM DATA WRITE"));
  EXPECT_EQ(ask(*session, "PRGM DATA?,RAM:1,STEP1\r\n"), "1,TEMP25.0,TEMP RAMP OFF,,TIME0:5,GRANTY OFF,\r\n");
  EXPECT_EQ(step("1", "PERHAPS"), "NA:CMD ERR\r\n");
  for (const auto* number : {"0", "-1", "100", "99999999999999999999"}) EXPECT_EQ(step(number, "ON"), "NA:CMD ERR\r\n");
}

}  // namespace
}  // namespace gyrotherm::simulator
