// SPDX-License-Identifier: Apache-2.0
// Rigs with a thermometer scanner that a file describes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
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

TEST(TextThermometerRig, ParametersReplaceThoseOfTheDescription) {
  const auto rig = parse_rig(
      rig_with(kScanner + "\nparameter = { channels = \"201:212\", channel_count = 12, nplc = 0.2 }"), kVirtualRig);
  ASSERT_TRUE(rig) << text(rig.error());
  const auto& description = *rig->thermometers[0].description;
  EXPECT_EQ(description.inputs, 12u);
  EXPECT_EQ(description.preparation[2].line, "CONF:TEMP FRTD,85,(@201:212)");
  EXPECT_EQ(description.preparation[4].line, "SENS:TEMP:NPLC 0.2,(@201:212)");
  const auto unknown = fault_of(kScanner + "\nparameter = { chanels = \"201:208\" }");
  EXPECT_NE(unknown.find("has no parameter \"chanels\", expected one of: channel_count, channels, nplc"),
            std::string::npos)
      << unknown;
  EXPECT_NE(unknown.find("virtual.toml:"), std::string::npos) << unknown;
  const auto count = fault_of(kScanner + "\nparameter = { channel_count = 0 }");
  EXPECT_NE(count.find("\"channel_count\" is 0, expected a whole number from 1 to 64"), std::string::npos) << count;
}

TEST(TextThermometerRig, LinkSettingsReplaceThoseOfTheDescription) {
  auto rig = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/example-f4t-lakeshore-kvh.toml").value();
  const std::string driver = "driver = \"lakeshore_218\"";
  const auto parsed = [&](const std::string& link) {
    auto text_of = rig;
    text_of.replace(text_of.find(driver), driver.size(),
                    "driver = \"text\"\ndescription = \"../thermometers/lakeshore_224.toml\"\nlink = { " + link + " }");
    return parse_rig(text_of, GYROTHERM_SOURCE_DIR "/profiles/rigs/example-f4t-lakeshore-kvh.toml");
  };
  const auto file =
      parsed("timeout = \"1500 ms\", after_read = \"70 ms\", after_write = \"90 ms\", unit = 7, echo = true");
  ASSERT_TRUE(file) << text(file.error());
  const auto& link = file->thermometers[0].description->unit.link;
  EXPECT_EQ(link.modbus.timeout, std::chrono::milliseconds(1500));
  EXPECT_EQ(link.text.after_read, std::chrono::milliseconds(70));
  EXPECT_EQ(link.text.after_write, std::chrono::milliseconds(90));
  EXPECT_EQ(link.modbus.unit, 7);
  EXPECT_TRUE(link.modbus.echo);
  const auto modbus_only = parsed("returns_other_unit = true");
  ASSERT_FALSE(modbus_only);
  const auto what = text(modbus_only.error());
  EXPECT_NE(what.find("unknown key \"returns_other_unit\""), std::string::npos) << what;
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
