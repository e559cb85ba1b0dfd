// SPDX-License-Identifier: Apache-2.0
#include "drivers/analogue/analogue_map.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/file.hpp"

namespace gyrotherm::drivers {
namespace {

const std::string kGood = R"(schema = "gyrotherm-analogue-inputs/1"
name = "ai"
vendor = "test"
source = "none"
[[register]]
name = "voltage"
address = 10
count = 3
spacing = 2
type = "s32"
scale = 1e-6
[[register]]
name = "state"
address = 30
count = 3
spacing = 1
type = "u16"
codes = { normal = 0, open = 1 }
[[register]]
name = "serial"
address = 40
type = "text"
characters = 8
[[register]]
name = "command"
address = 50
type = "u16"
access = "command"
)";

std::string mistake_in(const std::string& input) {
  const auto map = parse_analogue_map(kGood + "[[input]]\n" + input, "map.toml");
  return map ? "" : text(map.error());
}

TEST(AnalogueMap, RegistersThatAreAlikeAreAsManyInputs) {
  const auto map = parse_analogue_map(kGood + R"([[input]]
register = "voltage"
status = "state"
unit = "V"
[[input]]
register = "voltage_2"
unit = "V"
)",
                                      "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  EXPECT_EQ(map->inputs, (std::vector<AnalogueInput>{{"voltage_1", "V", {"state_1"}},
                                                     {"voltage_2", "V", {"state_2"}},
                                                     {"voltage_3", "V", {"state_3"}},
                                                     {"voltage_2", "V", {}}}));
  EXPECT_EQ(map->registers.find("voltage_3")->address, 14);
  EXPECT_EQ(map->registers.name, "ai");
  EXPECT_EQ(confidence_in_words(*map), "4 inputs: unverified");
}

TEST(AnalogueMap, EveryMistakeIsToldWithItsPlace) {
  const auto expect = [](const std::string& input, const std::string& what) {
    const auto mistake = mistake_in(input);
    EXPECT_NE(mistake.find(what), std::string::npos) << mistake;
    EXPECT_NE(mistake.find("map.toml:"), std::string::npos) << mistake;
  };
  expect("register = \"current\"\nunit = \"mA\"\n", "no register is named \"current\"");
  expect("register = \"voltage\"\n", "\"unit\"");
  expect("register = \"voltage\"\nunit = \"\"\n", "expected the unit of measure");
  expect("register = \"serial\"\nunit = \"V\"\n", "register \"serial\" is no number");
  expect("register = \"command\"\nunit = \"V\"\n", "register \"command\" cannot be read");
  expect("register = \"voltage\"\nunit = \"V\"\nstatus = \"state_1\"\n", "1 status registers for 3 inputs");
  expect("register = \"voltage_1\"\nunit = \"V\"\nstatus = \"voltage_2\"\n", "no code named \"normal\"");
  expect("register = \"voltage\"\nunit = \"V\"\nstatus = [\"state\", \"mode\"]\n", "no register is named \"mode\"");
  expect("register = \"voltage\"\nunits = \"V\"\n", "units");
}

TEST(AnalogueMap, WithoutInputsIsNone) {
  const auto map = parse_analogue_map(kGood, "map.toml");
  ASSERT_FALSE(map);
  EXPECT_NE(text(map.error()).find("missing [[input]]"), std::string::npos);
}

TEST(AnalogueMap, AChambersMapIsNone) {
  const auto text_of = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/virtual.toml").value();
  EXPECT_FALSE(parse_analogue_map(text_of, "virtual.toml"));
}

TEST(AnalogueMap, EveryShippedOneIsRead) {
  int maps = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/analogue-inputs")) {
    if (entry.path().extension() != ".toml") continue;
    ++maps;
    const auto map = parse_analogue_map(read_text_file(entry.path()).value(), entry.path());
    EXPECT_TRUE(map) << text(map.error());
  }
  EXPECT_GE(maps, 1);
}

}  // namespace
}  // namespace gyrotherm::drivers
