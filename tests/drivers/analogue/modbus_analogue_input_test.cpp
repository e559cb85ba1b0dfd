// SPDX-License-Identifier: Apache-2.0
#include "drivers/analogue/modbus_analogue_input.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/file.hpp"
#include "tests/support/fakes.hpp"

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

TEST(AnalogueMap, MakesOneInputPerCountedRegister) {
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
  EXPECT_EQ(describe_confidence(*map), "4 inputs: unverified");
}

TEST(AnalogueMap, ReportsEachErrorWithItsPosition) {
  const auto expect = [](const std::string& input, const std::string& what) {
    const auto mistake = mistake_in(input);
    EXPECT_NE(mistake.find(what), std::string::npos) << mistake;
    EXPECT_NE(mistake.find("map.toml:"), std::string::npos) << mistake;
  };
  expect("register = \"current\"\nunit = \"mA\"\n", "no register is named \"current\"");
  expect("register = \"voltage\"\n", "\"unit\"");
  expect("register = \"voltage\"\nunit = \"\"\n", "expected the unit of measure");
  expect("register = \"serial\"\nunit = \"V\"\n", "register \"serial\" is not a number");
  expect("register = \"command\"\nunit = \"V\"\n", "register \"command\" cannot be read");
  expect("register = \"voltage\"\nunit = \"V\"\nstatus = \"state_1\"\n", "1 status registers for 3 inputs");
  expect("register = \"voltage_1\"\nunit = \"V\"\nstatus = \"voltage_2\"\n", "no code named \"normal\"");
  expect("register = \"voltage\"\nunit = \"V\"\nstatus = [\"state\", \"mode\"]\n", "no register is named \"mode\"");
  expect("register = \"voltage\"\nunits = \"V\"\n", "units");
}

TEST(AnalogueMap, RequiresAnInput) {
  const auto map = parse_analogue_map(kGood, "map.toml");
  ASSERT_FALSE(map);
  EXPECT_NE(text(map.error()).find("missing [[input]]"), std::string::npos);
}

TEST(AnalogueMap, RejectsChamberMap) {
  const auto text_of = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/virtual.toml").value();
  EXPECT_FALSE(parse_analogue_map(text_of, "virtual.toml"));
}

TEST(AnalogueMap, ReadsEveryShippedMap) {
  int maps = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/analogue-inputs")) {
    if (entry.path().extension() != ".toml") continue;
    ++maps;
    const auto map = parse_analogue_map(read_text_file(entry.path()).value(), entry.path());
    EXPECT_TRUE(map) << text(map.error());
  }
  EXPECT_GE(maps, 1);
}

const std::string kUnit = R"(schema = "gyrotherm-analogue-inputs/1"
name = "AI-4"
vendor = "Acme"
source = "none"
[link]
read_at_most = 16
[[register]]
name = "current"
address = 0
count = 4
spacing = 1
type = "u16"
scale = 0.001
sentinels = { over_range = 65535 }
[[register]]
name = "state"
address = 60
count = 4
spacing = 1
type = "u16"
codes = { normal = 0, burn_out = 1 }
[[register]]
name = "model"
address = 100
type = "u16"
[identity]
register = "model"
value = 4711
[[input]]
register = "current"
status = "state"
unit = "mA"
)";

/// A unit on in-memory registers, with 1, 2, 3 and 4 mA.
struct Unit {
  explicit Unit(std::vector<std::size_t> wanted, const std::string& text = kUnit) {
    auto map = parse_analogue_map(text, "map.toml");
    auto made = std::make_unique<tests::FakeRegisters>();
    registers = made.get();
    registers->words = {{0, 1000}, {1, 2000}, {2, 3000}, {3, 4000}, {60, 0}, {61, 0}, {62, 0}, {63, 0}, {100, 4711}};
    inputs = make_modbus_analogue_inputs(std::move(map.value()), std::move(wanted), "analogue input 2", std::move(made),
                                         make_virtual_pauses());
  }
  tests::FakeRegisters* registers;
  std::unique_ptr<AnalogueInputs> inputs;
};

TEST(ModbusAnalogueInputs, ReturnsRequestedInputsInOrder) {
  Unit unit({2, 0});
  const auto readings = unit.inputs->read();
  ASSERT_EQ(readings.size(), 2u);
  EXPECT_DOUBLE_EQ(readings[0].value(), 3);
  EXPECT_DOUBLE_EQ(readings[1].value(), 1);
}

TEST(ModbusAnalogueInputs, RegistersThatFollowEachOtherAreOneExchange) {
  Unit unit({0, 1, 2, 3});
  (void)unit.inputs->read();
  EXPECT_EQ(unit.registers->reads, 2) << "currents and states";
}

TEST(ModbusAnalogueInputs, ReadsAcrossHolesInOneExchange) {
  auto text = kUnit;
  text.replace(text.find("read_at_most = 16"), 17, "holes = true");
  Unit unit({0, 3}, text);
  for (std::uint16_t at = 4; at < 60; ++at) unit.registers->words[at] = 0;
  EXPECT_DOUBLE_EQ(unit.inputs->read()[1].value(), 4);
  EXPECT_EQ(unit.registers->reads, 1);
}

TEST(ModbusAnalogueInputs, NoExchangeIsLongerThanTheLinkAllows) {
  auto text = kUnit;
  text.replace(text.find("read_at_most = 16"), 17, "read_at_most = 2");
  Unit unit({3}, text);
  EXPECT_DOUBLE_EQ(unit.inputs->read()[0].value(), 4);
  EXPECT_EQ(unit.registers->reads, 2) << "what holds no input that is wanted is not read";
}

TEST(ModbusAnalogueInputs, ReportsIdentity) {
  Unit unit({0});
  EXPECT_EQ(unit.inputs->identify(), "Acme AI-4 (model = 4711)");
  unit.registers->words[100] = 5;
  const auto another = unit.inputs->identify();
  ASSERT_FALSE(another);
  EXPECT_EQ(another.error().kind, FaultKind::mismatch);
  EXPECT_EQ(another.error().where, "analogue input 2 register 100 (model)");
}

TEST(ModbusAnalogueInputs, ReportsFaultOfOneInput) {
  Unit unit({0, 1, 2});
  unit.registers->words[61] = 1;
  unit.registers->words[2] = 65535;
  const auto readings = unit.inputs->read();
  EXPECT_DOUBLE_EQ(readings[0].value(), 1);
  ASSERT_FALSE(readings[1]);
  EXPECT_EQ(readings[1].error().kind, FaultKind::out_of_range);
  EXPECT_EQ(text(readings[1].error()), "analogue input 2 register 61 (state_2): burn_out");
  ASSERT_FALSE(readings[2]);
  EXPECT_EQ(readings[2].error().kind, FaultKind::out_of_range);
  EXPECT_NE(text(readings[2].error()).find("analogue input 2 register 2 (current_3)"), std::string::npos);
}

TEST(ModbusAnalogueInputs, ReportsInputWithDifferentRange) {
  auto text_of = kUnit + R"([[register]]
name = "mode"
address = 24
count = 4
spacing = 1
type = "u16"
codes = { normal = [1, 4], "0 … 20 mA" = 2 }
otherwise = "no current"
)";
  text_of.replace(text_of.find("status = \"state\""), 16, "status = [\"mode\", \"state\"]");
  Unit unit({0, 1, 2, 3}, text_of);
  for (const auto& [input, mode] : std::map<std::uint16_t, std::uint16_t>{{0, 1}, {1, 2}, {2, 4}, {3, 0}})
    unit.registers->words[static_cast<std::uint16_t>(24 + input)] = mode;
  const auto readings = unit.inputs->read();
  EXPECT_DOUBLE_EQ(readings[0].value(), 1);
  EXPECT_EQ(text(readings[1].error()), "analogue input 2 register 25 (mode_2): 0 … 20 mA");
  EXPECT_DOUBLE_EQ(readings[2].value(), 3);
  EXPECT_EQ(text(readings[3].error()), "analogue input 2 register 27 (mode_4): no current");
  unit.registers->words[60] = 1;
  EXPECT_EQ(text(unit.inputs->read()[0].error()), "analogue input 2 register 60 (state_1): burn_out");
}

TEST(ModbusAnalogueInputs, ReportsSilenceAfterOneExchange) {
  Unit unit({0, 1});
  unit.registers->fall_silent();
  for (const auto& reading : unit.inputs->read()) {
    ASSERT_FALSE(reading);
    EXPECT_EQ(reading.error().kind, FaultKind::timeout);
  }
  EXPECT_EQ(unit.registers->reads, 1) << "a dead line is not asked again in the same second";
  unit.registers->recover();
  EXPECT_TRUE(unit.inputs->read()[1]);
}

TEST(ModbusAnalogueInputs, ReadsOtherInputsWhenUnitRefusesOne) {
  auto text = kUnit;
  text.replace(text.find("read_at_most = 16"), 17, "read_at_most = 1");
  Unit unit({0, 1}, text);
  unit.registers->words.erase(1);
  const auto readings = unit.inputs->read();
  EXPECT_TRUE(readings[0]);
  ASSERT_FALSE(readings[1]);
  EXPECT_EQ(readings[1].error().kind, FaultKind::refused);
}

/// A unit with a failed first input: exception 4.
class Ailing final : public Registers {
 public:
  Result<std::vector<std::uint16_t>> read(ReadFunction, std::uint16_t address, std::uint16_t count) override {
    if (address == 0) return failure(FaultKind::out_of_range, "unit", "exception 4, server device failure");
    return std::vector<std::uint16_t>(count, 0);
  }
  Result<void> write(WriteFunction, std::uint16_t, std::span<const std::uint16_t>) override { return {}; }
};

TEST(ModbusAnalogueInputs, ReadsOtherInputsWhenOneHasNoValue) {
  auto text = kUnit;
  text.replace(text.find("read_at_most = 16"), 17, "read_at_most = 1");
  const auto inputs =
      make_modbus_analogue_inputs(parse_analogue_map(text, "map.toml").value(), {0, 1}, "analogue input 2",
                                  std::make_unique<Ailing>(), make_virtual_pauses());
  const auto readings = inputs->read();
  EXPECT_FALSE(readings[0]);
  EXPECT_TRUE(readings[1]);
}

}  // namespace
}  // namespace gyrotherm::drivers
