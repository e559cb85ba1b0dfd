// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "drivers/thermometer/text_thermometer.hpp"
#include "simulator/servers/memory_line.hpp"
#include "simulator/servers/scanner_server.hpp"
#include "tests/simulator/servers/asking.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

drivers::ThermometerDescription read_description(const std::filesystem::path& file) {
  auto description = drivers::parse_thermometer_description(read_text_file(file.string()).value_or(""), file.string());
  EXPECT_TRUE(description) << text(description.error());
  return std::move(*description);
}

const std::filesystem::path kDescriptions = GYROTHERM_SOURCE_DIR "/profiles/thermometers";

/// Identifies and reads the virtual scanner twice by its driver, on the selected link.
void expect_served(const drivers::ThermometerDescription& description, const VirtualLaboratory& laboratory) {
  std::mutex guard;
  const std::vector<std::size_t> inputs{8, 0, 3};
  auto line = make_answering_line([&] { return make_scanner_session(laboratory, description, inputs); }, guard);
  const auto driver = make_text_thermometer(description, std::move(line), description.unit.name);
  const auto identity = driver->identify();
  ASSERT_TRUE(identity) << text(identity.error());
  EXPECT_EQ(*identity, description.simulated.identity);
  for (int second = 0; second < 2; ++second) {
    const auto readings = driver->read();
    ASSERT_EQ(readings.size(), description.inputs);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      ASSERT_TRUE(readings[i]) << text(readings[i].error());
      EXPECT_NEAR(readings[i]->value, laboratory.thermometers_as_measured_c()[inputs[i]], 6e-4);
    }
    for (std::size_t i = inputs.size(); i < readings.size(); ++i) {
      ASSERT_FALSE(readings[i]) << description.unit.name;
      EXPECT_EQ(readings[i].error().kind, FaultKind::out_of_range) << text(readings[i].error());
    }
  }
}

TEST(ScannerSession, ServesTheDriverFromEveryShippedDescription) {
  const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kDescriptions)) {
    if (entry.path().extension() != ".toml") continue;
    ++files;
    auto description = read_description(entry.path());
    for (const auto& link : std::vector(description.unit.links)) {
      description.unit.link = link;
      description.unit.link.text.after_read = {};
      expect_served(description, laboratory);
    }
  }
  EXPECT_EQ(files, 7u);
}

TEST(ScannerSession, AnswersReadingsOnlyWhenPrepared) {
  const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  const auto file = (kDescriptions / "keysight_34970a.toml").string();
  auto content = read_text_file(file).value();
  constexpr std::string_view kOneLine = "ask = \"INIT;";
  content.replace(content.find(kOneLine), kOneLine.size(), "before = \"INIT\"\nask = \"");
  const auto description = drivers::parse_thermometer_description(content, file).value();
  const auto session = make_scanner_session(laboratory, description, {0});
  const std::string question = "*OPC?;FETC?\n";
  EXPECT_EQ(ask(*session, "INIT\n" + question), "");
  for (const auto& step : description.preparation) (void)ask(*session, step.line + "\n");
  EXPECT_EQ(ask(*session, "INIT\n"), "");
  const auto answer = ask(*session, question);
  EXPECT_TRUE(answer.starts_with("1;") && answer.ends_with(",+9.90000000E+37\n")) << answer;
  EXPECT_EQ(ask(*session, question), "") << "each scan needs its INIT";
  EXPECT_EQ(ask(*session, "*RST?\n"), "");
}

}  // namespace
}  // namespace gyrotherm::simulator
