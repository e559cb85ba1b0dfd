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
