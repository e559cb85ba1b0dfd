// SPDX-License-Identifier: Apache-2.0
/// The command `standard`: check runs of a golden gyro on virtual rigs.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <vector>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

std::string read_all(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

void replace(std::string& text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  ASSERT_NE(at, std::string::npos) << what;
  text.replace(at, what.size(), by);
}

/// A folder with rig.toml, a virtual rig with a golden gyro, and changed.toml, in which the correction of thermometer D
/// differs by 0.5 K.
class GoldenRig {
 public:
  GoldenRig() {
    const std::string profiles = std::string(GYROTHERM_SOURCE_DIR) + "/profiles/";
    auto rig = read_all(profiles + "rigs/virtual.toml");
    for (const std::string folder : {"chambers/", "gyros/"}) replace(rig, "\"../" + folder, '"' + profiles + folder);
    replace(rig, "[gyro]\n", "[gyro]\nserial_number = \"G-0001\"\n");
    rig += "\n[check_standard]\nserial_numbers = [\"G-0001\"]\n";
    std::ofstream(folder_ / "rig.toml") << rig;
    replace(rig, "offsets = [0, 0, 0, 0, 0, 0, 0, 0]", "offsets = [0, 0, 0, 0.5, 0, 0, 0, 0]");
    std::ofstream(folder_ / "changed.toml") << rig;
  }

  /// Makes a check run and returns the path of its record.
  std::string run(int day, const std::string& rig = "rig.toml", const std::string& profile = "check-standard") const {
    const auto record = folder_ / (profile + std::to_string(day) + rig + ".db");
    const auto ran = gyrotherm_with("run " + profile + " --rig " + (folder_ / rig) + " --days-later " +
                                    std::to_string(day) + " --out " + record);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return record;
  }

  auto standard(const std::string& arguments = "") const {
    return gyrotherm_with("standard " + (folder_ / "rig.toml") + " " + arguments);
  }
  std::string operator/(const std::string& name) const { return folder_ / name; }

 private:
  Folder folder_;
};

std::string records_of(const GoldenRig& rig, int runs) {
  std::string records;
  for (int day = 0; day < runs; ++day) records += rig.run(day) + " ";
  return records;
}

TEST(Standard, NamesChangedThermometerAndKeepsReportsDraftsUntilExplained) {
  const GoldenRig rig;
  const auto first = rig.standard(records_of(rig, 9) + "--chart " + (rig / "page.html"));
  ASSERT_EQ(first.exit_code, 0) << first.out << first.err;
  EXPECT_TRUE(first.out.starts_with("SIMULATED check standard G-0001")) << first.out;
  EXPECT_NE(first.out.find("in control"), std::string::npos);
  EXPECT_NE(read_all(rig / "page.html").find("SIMULATED"), std::string::npos);

  const auto record = rig.run(9, "changed.toml");
  const auto out = rig.standard("--json " + record);
  ASSERT_EQ(out.exit_code, 1) << out.out << out.err;
  const auto json = nlohmann::json::parse(out.out);
  EXPECT_TRUE(json["is_open"].get<bool>());
  EXPECT_TRUE(json["head"]["simulated"].get<bool>());
  EXPECT_EQ(json["diagnosis"]["named"], "thermometer");
  EXPECT_EQ(json["diagnosis"]["hypotheses"][0]["part"], "D");
  EXPECT_NEAR(json["diagnosis"]["hypotheses"][0]["amount"].get<double>(), 0.5, 0.05);

  const auto missing = [&](const std::string& of, const std::string& folder) {
    const auto made = gyrotherm_with("report " + of + " --check-standard " + (rig / "check-standard.jsonl") +
                                     " --out " + (rig / folder));
    EXPECT_EQ(made.exit_code, 0) << made.err;
    const auto listed = nlohmann::json::parse(read_all(rig / folder + "/calibration.json"))["missing"];
    return std::ranges::any_of(listed, [](const auto& one) {
      return one.template get<std::string>().starts_with("check standard of the rig virtual: out of control");
    });
  };
  EXPECT_TRUE(missing(record, "open"));
  EXPECT_FALSE(missing(rig / "check-standard5rig.toml.db", "earlier")) << "made before the last run in control";

  const auto explained = gyrotherm_with("standard explain " + (rig / "rig.toml") +
                                        " --cause thermometer --part D --new-level --by \"A. Metrologist\"");
  EXPECT_EQ(explained.exit_code, 0) << explained.out << explained.err;
  EXPECT_FALSE(missing(record, "explained"));
  const auto again = gyrotherm_with("standard explain " + (rig / "rig.toml") + " --cause other --by Me");
  EXPECT_EQ(again.exit_code, 2) << "nothing is open";
}

TEST(Standard, SkipsKnownRecordsAndRefusesEarlierOnes) {
  const GoldenRig rig;
  const auto later = rig.run(3), last = rig.run(4);
  ASSERT_EQ(rig.standard(last + " " + later).exit_code, 0) << "in the order of their time";
  const auto before = read_all(rig / "check-standard.jsonl");
  const auto again = rig.standard(later);
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.err.find("in the history already"), std::string::npos) << again.err;
  EXPECT_EQ(rig.standard(rig.run(1)).exit_code, 2);
  EXPECT_EQ(read_all(rig / "check-standard.jsonl"), before) << "a refused record changes nothing";
  EXPECT_EQ(rig.standard(last + " --chart x.png").exit_code, 2);
}

TEST(Standard, RefusesOtherProfileChangedHistoryAndRigWithoutGoldenGyro) {
  const GoldenRig rig;
  const auto other = rig.standard(rig.run(0, "rig.toml", "check-standard-turned"));
  EXPECT_EQ(other.exit_code, 2) << other.err;
  EXPECT_NE(other.err.find("check-standard-turned"), std::string::npos) << other.err;
  EXPECT_FALSE(std::filesystem::exists(rig / "check-standard.jsonl"));
  ASSERT_EQ(rig.standard(rig.run(0)).exit_code, 0);
  auto history = read_all(rig / "check-standard.jsonl");
  replace(history, "0.01", "0.02");
  std::ofstream(rig / "check-standard.jsonl") << history;
  EXPECT_EQ(rig.standard().exit_code, 4) << "a changed line";
  const auto without = gyrotherm_with("standard virtual");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_NE(without.err.find("[check_standard]"), std::string::npos) << without.err;
}

TEST(Standard, MeasuresEarthRateInTwoPositions) {
  const GoldenRig rig;
  auto text = read_all(rig / "rig.toml") + "profile = \"check-standard-turned\"\n";
  std::ofstream(rig / "rig.toml") << text;
  const auto out = rig.standard("--json " + rig.run(0, "rig.toml", "check-standard-turned"));
  ASSERT_EQ(out.exit_code, 0) << out.err;
  const auto json = nlohmann::json::parse(out.out);
  for (const auto& chart : json["charts"])
    if (chart["result"] == "earth_rate gyro 20 °C, turned") {
      EXPECT_NEAR(chart["points"][0]["value"].get<double>(), 0, 0.003) << "the mount is as the rig file states";
      return;
    }
  ADD_FAILURE() << out.out;
}

TEST(Standard, WritesChartsInGerman) {
  const GoldenRig rig;
  const auto chart = rig / "charts.html";
  ASSERT_EQ(rig.standard(records_of(rig, 6) + "--language de --chart " + chart).exit_code, 0);
  const auto page = read_all(chart);
  for (const auto* text : {"lang=\"de\"", "Regelkarten", "Nullpunktabweichung", "SIMULIERT", "role=\"img\""})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_EQ(rig.standard("--chart " + chart).exit_code, 2) << "exists";
  EXPECT_EQ(rig.standard("--force --chart " + (rig / "charts.svg")).exit_code, 0);
  EXPECT_NE(read_all(rig / "charts.svg").find("Control charts of the check standard G-0001"), std::string::npos);
}

TEST(Standard, KeepsEveryRunOfProgramsThatWriteAtOnce) {
  const GoldenRig rig;
  std::vector<std::string> records;
  for (int day = 0; day < 6; ++day) records.push_back(rig.run(day));
  ASSERT_EQ(rig.standard(records[0]).exit_code, 0);
  std::vector<std::unique_ptr<Background>> programs;
  for (int i = 0; i < 6; ++i) {
    std::vector<std::string> arguments{"standard", rig / "rig.toml"};
    arguments.insert(arguments.end(), records.begin(), records.end());
    programs.push_back(std::make_unique<Background>(arguments, rig / ("out" + std::to_string(i))));
  }
  for (const auto& program : programs) EXPECT_EQ(program->wait(), 0) << program->output();
  const auto checked = rig.standard("--json");
  ASSERT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_EQ(nlohmann::json::parse(checked.out)["runs"].size(), 6u) << "each run once, in an intact chain";
}

TEST(Standard, WaitsForLockAndLosesNoRunOfTheOtherProgram) {
  const GoldenRig rig;
  const auto first = rig.run(0), second = rig.run(1), third = rig.run(2);
  ASSERT_EQ(rig.standard(first).exit_code, 0);
  const auto history = rig / "check-standard.jsonl";
  const int file = ::open((history + ".lock").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(file, 0) << "the lock of the first run remains";
  struct flock whole {};
  whole.l_type = F_WRLCK;
  ASSERT_EQ(::fcntl(file, F_OFD_SETLK, &whole), 0);
  Background waiting({"standard", rig / "rig.toml", second, third}, rig / "out");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_TRUE(waiting.is_running());
  EXPECT_EQ(rig.standard().exit_code, 0) << "reading does not wait";
  // Another program with the lock adds the second run meanwhile.
  const auto before = read_all(history);
  std::filesystem::create_directory(rig / "elsewhere");
  std::filesystem::copy_file(rig / "rig.toml", rig / "elsewhere/rig.toml");
  std::filesystem::copy_file(history, rig / "elsewhere/check-standard.jsonl");
  ASSERT_EQ(gyrotherm_with("standard " + (rig / "elsewhere/rig.toml") + " " + second).exit_code, 0);
  std::filesystem::copy_file(rig / "elsewhere/check-standard.jsonl", history,
                             std::filesystem::copy_options::overwrite_existing);
  ASSERT_EQ(::close(file), 0);
  EXPECT_EQ(waiting.wait(), 0) << waiting.output();
  const auto after = read_all(history);
  EXPECT_TRUE(after.starts_with(before));
  EXPECT_EQ(std::ranges::count(after, '\n'), 4) << "the head and three runs";
}

TEST(Standard, ReleasesLockOfKilledProgramAndRefusesFolderThatCannotBeWritten) {
  const GoldenRig rig;
  const auto first = rig.run(0), second = rig.run(1);
  {
    Background killed({"standard", rig / "rig.toml", first, second}, rig / "out");
    killed.signal(SIGKILL);
    killed.wait();
  }
  ASSERT_EQ(rig.standard(first + " " + second).exit_code, 0);
  std::filesystem::remove(rig / "check-standard.jsonl.lock");
  std::filesystem::create_directory(rig / "check-standard.jsonl.lock");
  EXPECT_EQ(rig.standard(first).exit_code, 4) << "the lock cannot be opened";
}

}  // namespace
}  // namespace gyrotherm::app
