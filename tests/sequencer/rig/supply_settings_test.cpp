// SPDX-License-Identifier: Apache-2.0
// Power supplies of rig files.
#include "sequencer/rig/supply_settings.hpp"

#include <gtest/gtest.h>

#include <string>

#include "core/file.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::rig {
namespace {

const std::string kSupplyRigFile = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-supply.toml";

/// Returns the rig file with one text replaced.
std::string supply_rig_with(const std::string& from, const std::string& to) {
  auto rig = read_text_file(kSupplyRigFile).value();
  EXPECT_NE(rig.find(from), std::string::npos) << from;
  return rig.replace(rig.find(from), from.size(), to);
}

std::string supply_fault(const std::string& from, const std::string& to) {
  const auto rig = parse_rig(supply_rig_with(from, to), kSupplyRigFile);
  return rig ? "" : text(rig.error());
}

TEST(SupplySettings, AreReadWithTheirDefaults) {
  const auto rig = parse_rig(supply_rig_with("on_stop = \"keep\"", ""), kSupplyRigFile);
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_EQ(rig->supplies.size(), 1u);
  const auto& supply = rig->supplies[0];
  EXPECT_FALSE(supply.is_off_on_stop);
  EXPECT_EQ(supply.boot, std::chrono::seconds(5));
  ASSERT_EQ(supply.outputs.size(), 1u);
  const auto& output = supply.outputs[0];
  EXPECT_EQ(output.settings.output, 0u);
  EXPECT_EQ(output.settings.over_voltage_v, 26);
  EXPECT_EQ(output.voltage.highest, 25);
  EXPECT_FALSE(output.current.lowest);
  EXPECT_EQ(output_title(0, output), "supply 1, output 1");
  EXPECT_EQ(rig->units[0].analogue_values, 2u);
  EXPECT_EQ(rig->limits.units[0].analogue, (std::vector<std::string>{"supply_voltage_v", "supply_current_a"}));
  EXPECT_TRUE(list_unfed_units(rig->supplies, rig->units).empty());
}

TEST(SupplySettings, AreParsedFromTheTextOfARecord) {
  const auto texts = collect_supply_texts(parse_rig(supply_rig_with("", ""), kSupplyRigFile).value());
  ASSERT_EQ(texts.size(), 1u);
  const auto moved = supply_rig_with("keysight_e36312a", "none");
  EXPECT_FALSE(parse_rig(moved, kSupplyRigFile));
  EXPECT_TRUE(parse_rig(moved, kSupplyRigFile, {.supply_descriptions = texts}));
}

TEST(SupplySettings, RefuseErrorsWithTheirPositions) {
  const auto refuses = [](const std::string& from, const std::string& to, const std::string& what) {
    const auto fault = supply_fault(from, to);
    EXPECT_NE(fault.find("virtual-supply.toml:"), std::string::npos) << to << ": " << fault;
    EXPECT_NE(fault.find(what), std::string::npos) << to << ": " << fault;
  };
  refuses("voltage_v = 24.0", "", "voltage_v");
  refuses("current_a = 1.0 ", "current_a = 0 ", "above zero");
  refuses("output = 1 ", "output = 4 ", "3 outputs");
  refuses("over_voltage_v = 26.0", "over_voltage_v = 23.0", "not above the voltage");
  refuses("over_current_a = 1.0", "over_current_a = 1.2", "trips at its current limit");
  refuses("lowest_v = 23.0", "lowest_v = 24.5", "below this limit");
  refuses("highest_a = 0.8", "highest_a = 0.8\nlowest_a = 0.9", "not below the upper one");
  refuses("highest_a = 0.8", "highest_a = 0.8\ngyros = [\"other\"]", "not one of this rig's gyros");
  refuses("on_stop = \"keep\"", "on_stop = \"zero\"", "not one of keep, off");
  refuses("boot = \"5 s\"", "boot = \"2 h\"", "at most 30 min");
  refuses("line = \"virtual\"          # a real one: \"tcp://192.168.1.40\"", "line = \"tcp://192.168.1.40\"",
          "virtual");
}

TEST(SupplySettings, QueryVirtualSupplyWithoutChangingIt) {
  const auto file = parse_rig(supply_rig_with("", ""), kSupplyRigFile);
  ASSERT_TRUE(file) << text(file.error());
  const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  const auto answers = (*rig)->query_instruments();
  ASSERT_TRUE(answers.back()) << text(answers.back().error());
  EXPECT_TRUE(
      answers.back()->starts_with("supply 1: Keysight Technologies,E36312A,MY59001234,2.1.0-1.0.4-1.12, output "
                                  "1 on (over_voltage 26 V, voltage 24 V, current 1 A), 24.000 V, 0.4"))
      << *answers.back();
  EXPECT_EQ(answers.back()->find("WARNING"), std::string::npos) << *answers.back();
}

}  // namespace
}  // namespace gyrotherm::rig
