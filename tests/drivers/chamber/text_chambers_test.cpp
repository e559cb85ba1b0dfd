// SPDX-License-Identifier: Apache-2.0
// The shipped files of text chambers form and read the lines that public sources contain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/file.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_link.hpp"
#include "drivers/line/text_frame.hpp"

namespace gyrotherm::drivers {
namespace {

RegisterMap read_text_chamber(const std::string& name) {
  const auto file = GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml";
  const auto content = read_text_file(file);
  EXPECT_TRUE(content) << file;
  auto map = parse_register_map(content.value_or(""), file);
  EXPECT_TRUE(map) << text(map.error());
  return std::move(*map);
}

/// Returns the command that writes the raw value of an item.
std::string command_line(const RegisterMap& map, std::string_view item, const FieldValues& values) {
  for (const auto& command : map.text_link->commands)
    if (map.items[command.item].name == item) return command.tell.format(values);
  return "no command";
}

std::string question_line(const RegisterMap& map, std::string_view item) {
  const auto* query = map.text_link->find_query(map.find(item)->address);
  return query ? query->ask : "no question";
}

/// Returns the number of a field in an answer, or NaN if no form of the answer fits.
double number_in_answer(const RegisterMap& map, std::string_view item, std::string_view answer,
                        const std::string& field) {
  const auto* query = map.text_link->find_query(map.find(item)->address);
  for (const auto& form : query->answers)
    if (const auto fields = form.match(answer)) return std::get<double>(fields->at(field));
  return std::nan("");
}

TEST(TextChambers, SimServHasThePublishedBytes) {
  const auto map = read_text_chamber("weiss_simserv");
  EXPECT_EQ(command_line(map, "set_point", {{"value", -40.0}}), "11001\xB6\x31\xB6\x31\xB6-40.0");
  EXPECT_EQ(command_line(map, "run", {{"value", 1.0}}), "14001\xB6\x31\xB6\x31\xB6\x31");
  EXPECT_EQ(question_line(map, "air_temperature"), "11004\xB6\x31\xB6\x31");
  EXPECT_EQ(number_in_answer(map, "air_temperature", "1\xB6\x32\x34.4812", "value"), 24.4812);
  EXPECT_TRUE(std::isnan(number_in_answer(map, "air_temperature", "-8", "value")));
  EXPECT_EQ(map.link.modbus.port, 2049);
}

TEST(TextChambers, Ascii2RepeatsThePresentValues) {
  const auto map = read_text_chamber("weiss_ascii2");
  EXPECT_EQ(map.link.text.prefix->format({{"address", 1.0}}) + question_line(map, "set_point"), "$01I");
  const std::string others(30, '0');
  const FieldValues values{
      {"value", -40.0}, {"fan_set_point", 100.0}, {"do00", 0.0}, {"run", 1.0}, {"do02_to_do31", others}};
  EXPECT_EQ(command_line(map, "set_point", values), "E -040.0 0000.0 0100.0 0000.0 0000.0 0000.0 0000.0 01" + others);
}

TEST(TextChambers, P300HasThePublishedLines) {
  const auto map = read_text_chamber("espec_p300");
  EXPECT_EQ(command_line(map, "set_point", {{"value", -40.0}}), "TEMP, S-40.0");
  EXPECT_EQ(number_in_answer(map, "set_point", "23.0,85.0,105.0,-45.0", "alarm_low"), -45);
  EXPECT_EQ(number_in_answer(map, "alarms", "23.0,85,CONSTANT,0", "alarms"), 0);
  EXPECT_EQ(number_in_answer(map, "alarms", "23.0,,CONSTANT,2", "alarms"), 2);
  EXPECT_EQ(number_in_answer(map, "alarms", "23.0,CONSTANT,1", "alarms"), 1);
}

/// Returns the line of a program that contains `part`, with these fields.
std::string stored_line(const RegisterMap& map, std::string_view part, const FieldValues& fields) {
  for (const auto& line : map.text_link->memory) {
    const auto sent = line.tell.format(fields);
    if (sent.find(part) != std::string::npos) return sent;
  }
  return "no line";
}

TEST(TextChambers, P300ProgramsHaveThePublishedLines) {
  const auto map = read_text_chamber("espec_p300");
  const FieldValues step{{"number", 3.0},
                         {"step", 2.0},
                         {"target", -40.0},
                         {"kind", std::string("ON")},
                         {"hours", 1.0},
                         {"minutes", 5.0},
                         {"guaranteed_soak", std::string("OFF")}};
  EXPECT_EQ(stored_line(map, "STEP2", step),
            "PRGM DATA WRITE, PGM3, STEP2, TEMP-40.0, TRAMPON, TIME1:05, GRANTY OFF, PAUSE OFF");
  EXPECT_EQ(stored_line(map, "EDIT START", step), "PRGM DATA WRITE, PGM3, EDIT START");
  EXPECT_EQ(stored_line(map, "EDIT END", step), "PRGM DATA WRITE, PGM3, EDIT END");
  EXPECT_EQ(stored_line(map, "END, HOLD", step), "PRGM DATA WRITE, PGM3, END, HOLD");
  EXPECT_EQ(command_line(map, "run_program", {{"value", 3.0}}), "PRGM, RUN, RAM:3, STEP1");
  const auto& lines = map.text_link->memory;
  const auto found = std::ranges::find_if(lines, [](const auto& line) { return line.stride > 0; });
  ASSERT_NE(found, lines.end());
  EXPECT_EQ(found->ask->format(step), "PRGM DATA?,RAM:3,STEP2");
  for (const auto* answer : {"2,TEMP-40.0,TEMP RAMP ON,TIME1:5,GRANTY OFF,REF9,PAUSE OFF",
                             "2,TEMP-40.0,TEMP RAMP ON,HUMI OFF,TIME1:05,GRANTY OFF,REF9,RELAY ON1.2,PAUSE OFF",
                             "2,TEMP-40.0,TEMP RAMP ON,PTC OFF,HUMI85,HUMI RAMP OFF,TIME1:05,GRANTY OFF,REF9"}) {
    std::optional<FieldValues> fields;
    for (const auto& form : found->answers)
      if (!fields) fields = form.match(answer, NumberCheck::point);
    ASSERT_TRUE(fields) << answer;
    (*fields)["number"] = 3.0;
    EXPECT_EQ(to_words(*found, *fields), to_words(*found, step)) << answer;
  }
}

TEST(TextChambers, Thermotron3800StartsNoStoppedUnitByASetPoint) {
  const auto map = read_text_chamber("thermotron_3800");
  EXPECT_EQ(command_line(map, "set_point", {{"value", 25.0}}), "SETP1,25.0");
  const auto* command = map.text_link->find_command(map, map.find("set_point")->address);
  ASSERT_TRUE(command && command->then_when);
  EXPECT_EQ(command->then, std::vector<std::string>{"RUNM"});
  EXPECT_TRUE(holds(*command->then_when, 16));
  EXPECT_FALSE(holds(*command->then_when, 2));
}

TEST(TextChambers, LaudaTypeIsAParameter) {
  const auto map = read_text_chamber("lauda");
  for (const auto* known : {"XT", "RP245E", "ECO", "VC 600"})
    EXPECT_TRUE(fits_expression(map.identity->pattern, known));
  for (const auto* other : {"ERR_3", "F25", "JULABO"}) EXPECT_FALSE(fits_expression(map.identity->pattern, other));
}

TEST(TextChambers, CtsFramesHaveThePublishedBytes) {
  const auto map = read_text_chamber("cts");
  const auto* serial = map.find(LinkKind::text_serial);
  ASSERT_TRUE(serial && serial->text.frame && serial->text.prefix);
  const auto framed = [&](const std::string& line) {
    return to_frame(*serial->text.frame, serial->text.prefix->format({}) + line);
  };
  EXPECT_EQ(framed(question_line(map, "air_temperature")), "\x02\x81\xC1\xB0\xF0\x03");
  EXPECT_EQ(framed(command_line(map, "run", {{"value", 1.0}})), "\x02\x81\xF3\xB1\xA0\xB1\xD2\x03");
  EXPECT_EQ(framed(command_line(map, "run", {{"value", 0.0}})), "\x02\x81\xF3\xB1\xA0\xB0\xD3\x03");
  EXPECT_EQ(framed(question_line(map, "run")), "\x02\x81\xD3\xD2\x03");
  EXPECT_EQ(command_line(map, "set_point", {{"value", 23.0}}), "a0 023.0");
  EXPECT_EQ(command_line(map, "set_point", {{"value", -40.0}}), "a0 -40.0");
  EXPECT_EQ(number_in_answer(map, "set_point", "A0 023.4 025.0", "set_point"), 25);
}

TEST(TextChambers, CirculatorsHaveThePublishedLines) {
  const auto huber = read_text_chamber("huber");
  EXPECT_EQ(command_line(huber, "set_point", {{"value", -4000.0}}), "{M00F060");
  EXPECT_EQ(number_in_answer(huber, "set_point", "{S00F060", "value"), -4000);
  EXPECT_EQ(question_line(huber, "air_temperature"), "{M01****");
  const auto julabo = read_text_chamber("julabo");
  EXPECT_EQ(command_line(julabo, "set_point", {{"value", 55.5}}), "out_sp_00 55.50");
  EXPECT_EQ(number_in_answer(julabo, "status", "03 REMOTE START\r", "value"), 3);
  EXPECT_EQ(number_in_answer(julabo, "status", "-01 LOW LEVEL ALARM\r", "value"), -1);
  const auto lauda = read_text_chamber("lauda");
  EXPECT_EQ(command_line(lauda, "set_point", {{"value", -40.0}}), "OUT_SP_00_-40.00");
  EXPECT_TRUE(std::isnan(number_in_answer(lauda, "set_point", "ERR_6", "value")));
}

TEST(TextChambers, ThermotronAcceptsBothLineEnds) {
  const auto map = read_text_chamber("thermotron_8800");
  EXPECT_EQ(number_in_answer(map, "air_temperature", "22.000", "value"), 22);
  EXPECT_EQ(number_in_answer(map, "air_temperature", "22.000\r", "value"), 22);
}

}  // namespace
}  // namespace gyrotherm::drivers
