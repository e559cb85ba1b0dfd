// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/analogue_settings.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/file.hpp"
#include "sequencer/rig/rig.hpp"

namespace gyrotherm::rig {
namespace {

const std::string kTriad = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-triad.toml";

std::string change_triad(const std::string& what, const std::string& with) {
  auto text = read_text_file(kTriad).value();
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::string triad_errors(const std::string& what, const std::string& with) {
  const auto rig = parse_rig(change_triad(what, with), kTriad);
  return rig ? "" : text(rig.error());
}

TEST(AnalogueSettings, AddsValueOfEachChannelToItsGyro) {
  const auto rig = read_rig(kTriad);
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_EQ(rig->analogue_inputs.size(), 1u);
  const auto& settings = rig->analogue_inputs.front();
  EXPECT_EQ(settings.map.registers.name, "ioLogik E1240");
  ASSERT_EQ(settings.channels.size(), 3u);
  EXPECT_EQ(settings.channels[2].input, 2u);
  EXPECT_EQ(settings.channels[2].unit, 2u);
  for (const auto& unit : rig->units) {
    ASSERT_EQ(unit.info.values.size(), 1u);
    EXPECT_EQ(unit.info.values[0].name, "discharge_current_ma");
    EXPECT_EQ(unit.info.values[0].unit, "mA");
    EXPECT_EQ(unit.analogue_values, 1u);
  }
  EXPECT_EQ(rig->units[1].info.values[0].instrument, "ioLogik E1240 at virtual, input 2");
  EXPECT_EQ(analogue_channel(rig->limits.units[2], 0), "z.discharge_current_ma");
}

TEST(AnalogueSettings, ValuesOfStreamPrecedeAnalogueValues) {
  const auto lot = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-lot.toml";
  auto text_of = read_text_file(lot).value();
  const auto plain = parse_rig(text_of, lot);
  ASSERT_TRUE(plain) << text(plain.error());
  const auto& name = plain->units.back().info.name;
  text_of.insert(text_of.find("[limits]"), R"([[analogue_input]]
map = "../analogue-inputs/moxa_iologik_e1240.toml"
line = "virtual"
[[analogue_input.channel]]
input = 8
name = "cabinet"
unit = "°C"
temperature = true
gyro = ")" + name + "\"\n");
  const auto rig = parse_rig(text_of, lot);
  ASSERT_TRUE(rig) << text(rig.error());
  const auto &before = plain->units.back().info.values, &after = rig->units.back().info.values;
  ASSERT_EQ(after.size(), before.size() + 1);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin()));
  EXPECT_EQ(after.back().name, "cabinet");
  EXPECT_TRUE(after.back().is_temperature);
}

TEST(AnalogueSettings, ReportsEveryErrorWithPosition) {
  const auto expect = [](const std::string& what, const std::string& with, const std::string& mistake) {
    const auto found = triad_errors(what, with);
    EXPECT_NE(found.find(mistake), std::string::npos) << with << ": " << found;
    EXPECT_NE(found.find("virtual-triad.toml:"), std::string::npos) << found;
  };
  expect("input = 1 ", "input = 0 ", "\"input\" is 0, expected 1 to 8");
  expect("input = 2\n", "input = 9\n", "\"input\" is 9, expected 1 to 8");
  expect("gyro = \"y\"\nscale", "gyro = \"q\"\nscale", "\"q\" is not one of this rig's gyros");
  expect("gyro = \"y\"\nscale", "scale", "\"gyro\"");
  expect("gyro = \"y\"\nscale", "gyro = \"x\"\nscale",
         "\"discharge_current_ma\" is the name of another value of this gyro");
  expect("scale = 0.125\n", "scale = 0\n", "must not be zero");
  expect("unit = \"mA\"\ngyro = \"z\"", "unit = \"mA\"\ntemperature = true\ngyro = \"z\"", "a temperature is in");
  expect("unit = \"mA\"\ngyro = \"z\"", "gyro = \"z\"", "\"unit\"");
  expect("offset = -0.5\n", "ofset = -0.5\n", "offset");
  expect("e1240.toml\"", "e1241.toml\"", "e1241.toml");
  expect("line = \"virtual\"                                    #", "line = \"COM3\" #", "COM3");
  expect("line = \"virtual\"                                    #", "line = \"serial:/dev/ttyS0\" #", "rtu");
  expect("line = \"virtual\"                                    #", "line = \"tcp://10.0.0.7\" #", "wholly");
  expect("line = \"virtual\"                                    #", "word_order = \"abdc\"\nline = \"virtual\" #",
         "is not one of abcd");
}

TEST(AnalogueSettings, LinkSettingsReplaceThoseOfMap) {
  const std::string line = "line = \"virtual\"                                    #";
  const auto rig = parse_rig(change_triad(line, "link = { read_at_most = 40, timeout = \"900 ms\" }\n" + line), kTriad);
  ASSERT_TRUE(rig) << text(rig.error());
  const auto& link = rig->analogue_inputs.front().map.registers.link.modbus;
  EXPECT_EQ(link.read_at_most, 40);
  EXPECT_EQ(link.timeout, std::chrono::milliseconds(900));
  const auto echo = triad_errors(line, "link = { echo = true }\n" + line);
  EXPECT_NE(echo.find("a virtual line does not echo"), std::string::npos) << echo;
  EXPECT_NE(echo.find("virtual-triad.toml:"), std::string::npos) << echo;
}

TEST(AnalogueSettings, RefusesInputWithoutChannels) {
  auto text_of = read_text_file(kTriad).value();
  const auto from = text_of.find("[[analogue_input.channel]]"), to = text_of.find("# Interlocks.");
  text_of.erase(from, to - from);
  const auto rig = parse_rig(text_of, kTriad);
  ASSERT_FALSE(rig);
  EXPECT_NE(text(rig.error()).find("missing [[analogue_input.channel]]"), std::string::npos);
}

TEST(AnalogueSettings, ParsesWithMapsStoredInRecord) {
  const auto rig = read_rig(kTriad);
  ASSERT_TRUE(rig);
  const auto texts = collect_analogue_map_texts(*rig);
  ASSERT_EQ(texts.size(), 1u);
  const auto moved = change_triad("e1240.toml\"", "gone.toml\"");
  EXPECT_FALSE(parse_rig(moved, kTriad));
  EXPECT_TRUE(parse_rig(moved, kTriad, {.analogue_maps = texts}));
}

TEST(AnalogueSettings, QueriesIdentityAndReadings) {
  const auto file = read_rig(kTriad);
  ASSERT_TRUE(file) << text(file.error());
  const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  const auto answers = (*rig)->query_instruments();
  ASSERT_TRUE(answers.back()) << text(answers.back().error());
  EXPECT_TRUE(answers.back()->starts_with("analogue input 1: Moxa ioLogik E1240")) << *answers.back();
  EXPECT_NE(answers.back()->find("y.discharge_current_ma "), std::string::npos) << *answers.back();
  EXPECT_NE(answers.back()->find(" mA"), std::string::npos) << *answers.back();
}

}  // namespace
}  // namespace gyrotherm::rig
