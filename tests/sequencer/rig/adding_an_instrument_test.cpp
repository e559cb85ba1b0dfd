// SPDX-License-Identifier: Apache-2.0
/// The files of docs/adding-an-instrument.md parse, and run on the virtual laboratory.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "sequencer/rig/thermometer_settings.hpp"
#include "tests/support/dry_run.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::rig {
namespace {

/// Returns the page's files by path, which is their first line.
std::map<std::string, std::string> read_page_files() {
  std::istringstream page(read_text_file(GYROTHERM_SOURCE_DIR "/docs/adding-an-instrument.md").value());
  std::map<std::string, std::string> files;
  std::string path;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```")) {
      inside = line == "```toml" || line == "```python";
      path.clear();
    } else if (inside && path.empty()) {
      path = line.substr(2);
    } else if (inside) {
      files[path] += line + "\n";
    }
  }
  return files;
}

/// Returns the page's rig with the laboratory of the default rig and a chamber of the page.
Result<RigFile> parse_page_rig(const std::string& instead_of = "", const std::string& other = "",
                               const std::string& chamber = "profiles/chambers/acme_tc100.toml") {
  auto files = read_page_files();
  auto& rig = files["profiles/rigs/acme.toml"];
  if (!instead_of.empty()) rig.replace(rig.find(instead_of), instead_of.size(), other);
  const auto by_default = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml").value();
  const auto dry_run = by_default.substr(by_default.find("[analysis]"));
  return parse_rig(
      rig + dry_run, "acme.toml",
      {.chamber_map = files[chamber],
       .gyro_model = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/calibrated.reduced.toml").value(),
       .gyro_streams = {{"gyro", files["profiles/gyro-streams/acme-g1.toml"]}}});
}

TEST(AddingAnInstrument, PageFilesParse) {
  EXPECT_EQ(read_page_files().size(), 9u);
  const auto rig = parse_page_rig();
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->chamber_map.name, "TC-100");
  EXPECT_EQ(rig->gyro_lines[0].frame.name, "acme-g1");
  EXPECT_DOUBLE_EQ(rig->units[0].info.axes[0].scale, 0.01);
}

class PageChamber : public testing::TestWithParam<const char*> {};

TEST_P(PageChamber, RunsOnVirtualLaboratory) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/short-rate.toml");
  auto rig = parse_page_rig("", "", GetParam());
  ASSERT_TRUE(rig) << text(rig.error());
  dry_run.file() = std::move(*rig);
  dry_run.run(600);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  ASSERT_EQ(record->slot.size(), 600u);
  for (std::size_t i = 0; i < record->slot.size(); ++i) {
    ASSERT_NEAR(record->chamber_set_point_c[i], record->set_point_c[i], 0.051) << i;
    ASSERT_NEAR(record->info.units[0].axes[0].scale * record->units[0].rotation[0][i], 10.6, 1) << i;
    for (const auto& channel : record->thermometers_c) ASSERT_FALSE(std::isnan(channel[i])) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(AddingAnInstrument, PageChamber,
                         testing::Values("profiles/chambers/acme_tc100.toml", "acme_tc300.toml"),
                         [](const auto& one) { return std::string(one.index == 0 ? "Registers" : "Text"); });

TEST(AddingAnInstrument, PageProgramIsThermometer) {
  auto files = read_page_files();
  const tests::TestFolder folder;
  std::ofstream(folder / "acme_t2.py") << files["acme_t2.py"];
  const auto table = TomlTable::parse(files["acme_t2.toml"], folder / "acme_t2.toml");
  ASSERT_TRUE(table) << text(table.error());
  std::set<std::string> seen;
  DescriptionReader descriptions(folder / "acme_t2.toml");
  const auto settings = read_thermometer(table->tables("thermometer")[0], folder / "", 1, seen, descriptions);
  ASSERT_TRUE(table->verdict()) << text(table->verdict().error());
  const auto thermometer = make_process_thermometer(settings, "thermometer 1");
  const auto who = thermometer->identify();
  ASSERT_TRUE(who) << text(who.error());
  EXPECT_EQ(*who, "Acme T-2 0815");
  const auto readings = thermometer->read();
  ASSERT_EQ(readings.size(), settings.channels.size());
  EXPECT_EQ(readings[0].value(), Celsius{23.456});
  EXPECT_EQ(text(readings[1].error()), "thermometer 1 input 2: the program reports no reading");
}

TEST(AddingAnInstrument, ProcessDriverRequiresCommandInsteadOfLine) {
  const auto mistake = [](const std::string& keys) {
    const auto table =
        TomlTable::parse("[[thermometer]]\ndriver = \"process\"\nchannels = [\"A\"]\n" + keys, "rig.toml");
    std::set<std::string> seen;
    DescriptionReader descriptions("rig.toml");
    (void)read_thermometer(table->tables("thermometer")[0], ".", 1, seen, descriptions);
    const auto verdict = table->verdict();
    return verdict ? std::string() : text(verdict.error());
  };
  EXPECT_EQ(mistake("command = [\"acme\"]"), "");
  EXPECT_EQ(mistake("command = [\"acme\"]\nline = \"virtual\""), "");
  EXPECT_NE(mistake("").find("no \"command\", expected a program"), std::string::npos);
  EXPECT_NE(mistake("command = []").find("expected a program"), std::string::npos);
  EXPECT_NE(mistake("command = [\"acme\"]\nline = \"tcp://1.2.3.4\"").find("a program has no line"), std::string::npos);
}

/// The page's rig, with process drivers for all thermometers. The virtual laboratory answers instead of the programs.
TEST(AddingAnInstrument, ProcessDriverRunsOnVirtualLaboratory) {
  tests::DryRun dry_run(GYROTHERM_SOURCE_DIR "/tests/profiles/short-rate.toml");
  auto rig = parse_page_rig("driver = \"pt12\"", "driver = \"process\"\ncommand = [\"./none\"]");
  ASSERT_TRUE(rig) << text(rig.error());
  dry_run.file() = std::move(*rig);
  dry_run.run(60);
  const auto record = record::read_record(dry_run.path());
  ASSERT_TRUE(record) << text(record.error());
  for (const auto& channel : record->thermometers_c)
    for (const double reading : channel) EXPECT_FALSE(std::isnan(reading));
}

TEST(AddingAnInstrument, PathsOnPageExist) {
  const auto page = read_text_file(GYROTHERM_SOURCE_DIR "/docs/adding-an-instrument.md").value();
  for (const auto* path :
       {"drivers/thermometer/pt12.hpp", "drivers/thermometer/pt12.cpp", "drivers/thermometer/thermometer_kinds.hpp",
        "sequencer/rig/thermometer_settings.cpp", "simulator/servers/virtual_thermometers.cpp",
        "simulator/virtual_instruments.cpp", "tests/drivers/gyro/frame_stream_test.cpp", "docs/chamber-maps.md",
        "profiles/gyro-streams/"}) {
    EXPECT_NE(page.find(path), std::string::npos) << path;
    EXPECT_TRUE(std::filesystem::exists(std::string(GYROTHERM_SOURCE_DIR "/") + path)) << path;
  }
}

}  // namespace
}  // namespace gyrotherm::rig
