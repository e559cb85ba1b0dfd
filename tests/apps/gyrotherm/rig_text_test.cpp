// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/rig_text.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "apps/gyrotherm/new_rig/interview.hpp"
#include "apps/gyrotherm/new_rig/new_files.hpp"
#include "core/file.hpp"
#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "sequencer/watchdog/safe_evidence.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::app {
namespace {

GivenAnswers answers_for(const std::string& chamber, const std::string& scanner, const std::string& gyro) {
  GivenAnswers given{.values = {{"--chamber", chamber},
                                {"--chamber-line", "tcp://10.0.0.5:4001"},
                                {"--lowest", "-20"},
                                {"--highest", "60"},
                                {"--fastest", "2"},
                                {"--gyro", gyro},
                                {"--gyro-line", "tcp://10.0.0.7:4001"},
                                {"--latitude", "47"}},
                     .scanners = {scanner, "lakeshore_218 serial:/dev/ttyS5 shell"}};
  return given;
}

/// Returns what is wrong with the rig file of these answers, or an empty text.
std::string flaw_of(GivenAnswers given, const std::string& file = "rig.toml") {
  auto answers = collect_answers(file, given, {});
  if (!answers && answers.error().where == "--arcsec-per-pulse") {
    given.values["--arcsec-per-pulse"] = "0.1";
    answers = collect_answers(file, given, {});
  }
  if (!answers && answers.error().where == "--chamber-line") {  // on a serial line only
    given.values["--chamber-line"] = "serial:/dev/ttyS4";
    answers = collect_answers(file, given, {});
  }
  if (!answers) return text(answers.error());
  const auto rig = rig::parse_rig(write_rig_text(*answers, {{"chamber", "line 1\n[evil]\x1b[2J"}}), file);
  return rig ? "" : text(rig.error()) + "\n" + write_rig_text(*answers, {});
}

TEST(RigText, IsRigFileForEveryShippedInstrument) {
  int seen = 0;
  for (const auto& chamber : shipped_names(kShippedChamberMap)) {
    EXPECT_EQ(flaw_of(answers_for(chamber, "lakeshore_218 tcp://10.0.0.6 8", "pulse-count")), "") << chamber;
    ++seen;
  }
  EXPECT_GE(seen, 25);
  seen = 0;
  for (const auto& gyro : shipped_names(kShippedGyroStream)) {
    EXPECT_EQ(flaw_of(answers_for("watlow_f4t", "lakeshore_218 tcp://10.0.0.6 8", gyro)), "") << gyro;
    ++seen;
  }
  EXPECT_GE(seen, 18);
  seen = 0;
  auto scanners = shipped_names(kShippedThermometer);
  scanners.insert(scanners.end(), {"pt12", "lakeshore_218"});
  for (const auto& scanner : scanners) {
    EXPECT_EQ(flaw_of(answers_for("watlow_f4t", scanner + " tcp://10.0.0.6:4001 A", "pulse-count")), "") << scanner;
    ++seen;
  }
  EXPECT_GE(seen, 8);
  EXPECT_EQ(flaw_of(answers_for("watlow_f4t", "dcon serial:/dev/ttyS6 addresses=1,2 type=T 8", "pulse-count")), "");
  EXPECT_EQ(flaw_of(answers_for("watlow_f4t", "mcc_usb_temp hid: 8", "pulse-count")), "");
}

TEST(RigText, QuotesWhateverWasTyped) {
  auto given = answers_for("watlow_f4t", "lakeshore_218 tcp://10.0.0.6 8", "pulse-count");
  given.values["--title"] = R"(a "bench" \ with [odd] # title = 1)";
  given.values["--serial-number"] = "00\"42";
  EXPECT_EQ(flaw_of(given, "odd \"name\".toml"), "");
}

TEST(RigText, KeepsAnswers) {
  auto given = answers_for("watlow_f4t", "lakeshore_218 tcp://10.0.0.6 A D", "stim300");
  given.values.insert({{"--chamber-unit", "7"}, {"--limiter", "3.1 75"}, {"--gyro-axis", "y"}, {"--elevation", "0"}});
  auto answers = collect_answers("bench.toml", given, {});
  ASSERT_TRUE(answers) << text(answers.error());
  answers->word_order = drivers::WordOrder::cdab;
  const auto rig = rig::parse_rig(write_rig_text(*answers, {}), "bench.toml");
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(rig->name, "bench");
  EXPECT_EQ(rig->chamber_map.link.modbus.unit, 7);
  EXPECT_EQ(rig->chamber_word_order, drivers::WordOrder::cdab);
  ASSERT_TRUE(rig->limiter);
  EXPECT_EQ(rig->limiter->highest->value, 75);
  EXPECT_FALSE(rig->limiter->lowest);
  EXPECT_EQ(rig->limits.air_highest.value, 67.5) << "halfway to the limiter";
  EXPECT_EQ(rig->units.at(0).info.three_point, (std::vector<std::string>{"A", "D", "shell"}));
  EXPECT_EQ(rig->units.at(0).info.gradients, (std::vector<std::string>{"A", "D"}));
  EXPECT_EQ(rig->gyro_lines.at(0).frame.axes, std::vector<std::string>{"y"});
}

TEST(RigText, NamesOwnMapRelativeToRigFile) {
  const tests::TestFolder folder;
  std::filesystem::create_directories(folder / "rigs");
  std::filesystem::copy_file(find_shipped_file("profiles/chambers/watlow_f4t.toml"), folder / "my map.toml");
  const auto file = folder / "rigs" + "/rig.toml";
  EXPECT_EQ(flaw_of(answers_for(folder / "my map.toml", "lakeshore_218 tcp://10.0.0.6 8", "pulse-count"), file), "");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder / "rigs");
  const auto given = answers_for("../my map.toml", "lakeshore_218 tcp://10.0.0.6 8", "pulse-count");
  EXPECT_EQ(flaw_of(given, "rig.toml"), "");
  std::filesystem::current_path(before);
}

std::size_t count_lines(const std::string& text) {
  return text.empty() ? 0 : 1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// Replaces each value to be filled in by the next of `values`.
std::string fill_in(std::string text, const std::vector<std::string>& values) {
  for (const auto& value : values) {
    const auto begins = text.find("\"FILL IN: ");
    if (begins == std::string::npos) return "too many values";
    text.replace(begins, text.find('"', begins + 1) + 1 - begins, value);
  }
  return text;
}

RigAnswers other_chamber(const char* kind) {
  RigAnswers answers;
  answers.file = "bench.toml";
  answers.chamber = kind;
  return answers;
}

TEST(ChamberSkeleton, ListsWhatIsMissingAndIsMapOnceFilledIn) {
  const auto skeleton = write_chamber_text(other_chamber(kOtherModbus));
  const auto refused = drivers::parse_register_map(skeleton, "m.toml");
  ASSERT_FALSE(refused);
  EXPECT_EQ(count_lines(refused.error().what), 6u);
  EXPECT_NE(refused.error().what.find("register with the air temperature"), std::string::npos);
  EXPECT_NE(skeleton.find("docs/chamber-maps.md"), std::string::npos);
  const auto partly = drivers::parse_register_map(fill_in(skeleton, {"\"TC\"", "\"Acme\""}), "m.toml");
  ASSERT_FALSE(partly);
  EXPECT_EQ(count_lines(partly.error().what), 4u);
  const auto map =
      drivers::parse_register_map(fill_in(skeleton, {"\"TC\"", "\"Acme\"", "\"manual\"", "10", "20", "30"}), "m.toml");
  ASSERT_TRUE(map) << text(map.error());
  std::vector<ChamberActivity> activities;
  for (const auto& state : map->states) activities.push_back(state.activity);
  EXPECT_EQ(activities, (std::vector{ChamberActivity::off, ChamberActivity::running}));
  EXPECT_TRUE(watchdog::safe_goal(*map, {20}, {}).shows_off) << "a chamber switched off at its panel is seen";
}

TEST(ChamberSkeleton, IsTextDescriptionOnceFilledIn) {
  const auto skeleton = write_chamber_text(other_chamber(kOtherText));
  const auto refused = drivers::parse_register_map(skeleton, "m.toml");
  ASSERT_FALSE(refused);
  EXPECT_EQ(count_lines(refused.error().what), 16u);
  const auto map = drivers::parse_register_map(
      fill_in(skeleton,
              {"\"TC\"", "\"Acme\"", "\"manual\"", "10001", "\"*IDN?\"", "\"ACME\"", "\"TEMP?\"", "\"SET?\"",
               "\"SET {value:f.1}\"", "\"MODE?\"", "\"OFF\"", "\"RUN\"", "\"START\"", "\"OK\"", "\"STOP\"", "\"OK\""}),
      "m.toml");
  EXPECT_TRUE(map) << text(map.error());
}

TEST(NewFiles, AreAllWrittenOrNone) {
  const tests::TestFolder folder;
  ASSERT_TRUE(create_files({{folder / "a", "1"}, {folder / "b", "2"}}));
  EXPECT_EQ(read_text_file(folder / "b").value(), "2");
  const auto refused = create_files({{folder / "c", "3"}, {folder / "b", "4"}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::usage);
  EXPECT_FALSE(std::filesystem::exists(folder / "c"));
  EXPECT_EQ(read_text_file(folder / "b").value(), "2");
  const auto lost = create_files({{folder / "c", "3"}, {folder / "no/d", "4"}});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, FaultKind::storage);
  EXPECT_FALSE(std::filesystem::exists(folder / "c"));
  std::filesystem::create_symlink(folder / "nowhere", folder / "link");
  EXPECT_FALSE(create_files({{folder / "link", "5"}})) << "a link is not followed";
  EXPECT_FALSE(std::filesystem::exists(folder / "nowhere"));
}

}  // namespace
}  // namespace gyrotherm::app
