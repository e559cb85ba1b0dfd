// SPDX-License-Identifier: Apache-2.0
// Rigs with a thermometer scanner that a file describes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "core/file.hpp"
#include "sequencer/rig/rig.hpp"

namespace gyrotherm::rig {
namespace {

const std::string kVirtualRig = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml";

/// Returns the virtual rig with `keys` in place of the driver of its first thermometer.
std::string rig_with(const std::string& keys) {
  auto rig = read_text_file(kVirtualRig).value();
  const std::string driver = "driver = \"lakeshore_218\"";
  rig.replace(rig.find(driver), driver.size(), keys);
  return rig;
}

const std::string kScanner = "driver = \"text\"\ndescription = \"../thermometers/keysight_34970a.toml\"";

std::string fault_of(const std::string& keys) {
  const auto rig = parse_rig(rig_with(keys), kVirtualRig);
  return rig ? "" : text(rig.error());
}

TEST(TextThermometerRig, ReadsTheDescriptionAndKeepsItsText) {
  const auto rig = parse_rig(rig_with(kScanner), kVirtualRig);
  ASSERT_TRUE(rig) << text(rig.error());
  ASSERT_TRUE(rig->thermometers[0].description);
  EXPECT_EQ(rig->thermometers[0].description->inputs, 8u);
  EXPECT_FALSE(rig->thermometers[1].description);
  const auto texts = collect_thermometer_texts(*rig);
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_EQ(texts[0], read_text_file(GYROTHERM_SOURCE_DIR "/profiles/thermometers/keysight_34970a.toml").value());
  const auto moved = rig_with("driver = \"text\"\ndescription = \"../thermometers/none.toml\"");
  EXPECT_FALSE(parse_rig(moved, kVirtualRig));
  EXPECT_TRUE(parse_rig(moved, kVirtualRig, {.thermometer_descriptions = texts}));
}

TEST(TextThermometerRig, ReadsTheVirtualScanner) {
  const auto file = parse_rig(rig_with(kScanner), kVirtualRig);
  ASSERT_TRUE(file) << text(file.error());
  const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  const auto answers = (*rig)->query_instruments();
  ASSERT_TRUE(answers[1]) << text(answers[1].error());
  EXPECT_TRUE(answers[1]->starts_with("thermometer 1: HEWLETT-PACKARD,34970A,0,13-2-2, A ")) << *answers[1];
  EXPECT_EQ(answers[1]->find("WARNING"), std::string::npos) << *answers[1];
}

TEST(TextThermometerRig, RefusesErrors) {
  EXPECT_NE(fault_of("driver = \"text\"").find("description"), std::string::npos);
  EXPECT_NE(fault_of("driver = \"text\"\ndescription = \"keysight\"").find("is not a shipped thermometer description"),
            std::string::npos);
  const auto wrong = fault_of("driver = \"text\"\ndescription = \"../chambers/espec_p300.toml\"");
  EXPECT_NE(wrong.find("espec_p300.toml:"), std::string::npos) << wrong;
  const auto few = fault_of("driver = \"text\"\ndescription = \"../thermometers/lakeshore_336.toml\"");
  EXPECT_NE(few.find("8 channels, expected 1 to 4"), std::string::npos) << few;
  const auto unused = fault_of("driver = \"lakeshore_218\"\ndescription = \"keysight_34970a\"");
  EXPECT_NE(unused.find("unknown key"), std::string::npos) << unused;
}

TEST(TextThermometerRig, SelectsTheLinkForTheLine) {
  auto rig = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/example-f4t-lakeshore-kvh.toml").value();
  const std::string driver = "driver = \"lakeshore_218\"";
  ASSERT_NE(rig.find(driver), std::string::npos);
  rig.replace(rig.find(driver), driver.size(),
              "driver = \"text\"\ndescription = \"../thermometers/lakeshore_224.toml\"");
  const auto file = parse_rig(rig, GYROTHERM_SOURCE_DIR "/profiles/rigs/example-f4t-lakeshore-kvh.toml");
  ASSERT_TRUE(file) << text(file.error());
  const auto& link = file->thermometers[0].description->unit.link;
  ASSERT_TRUE(file->thermometers[0].line.starts_with("serial:"));
  EXPECT_EQ(link.kind, drivers::LinkKind::text_serial);
  EXPECT_EQ(link.modbus.serial.baud, 57600);
  EXPECT_EQ(link.modbus.serial.parity, drivers::SerialParity::odd);
}

}  // namespace
}  // namespace gyrotherm::rig
