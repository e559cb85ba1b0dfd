// SPDX-License-Identifier: Apache-2.0
/// Real rigs on virtual instruments: on pseudo-terminals, and at the frame rate of a stream. Each test takes more than
/// ten seconds.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

/// Makes a real rig from the printed lines of `simulate` and runs ten seconds on it.
nlohmann::json status_after_ten_seconds(const Folder& folder, const std::string& virtual_rig,
                                        const std::string& lines) {
  const auto rig = shell("/usr/bin/python3 tests/apps/gyrotherm/real_rig.py " + virtual_rig + " " + lines + " > " +
                         (folder / "rig.toml"));
  EXPECT_EQ(rig.exit_code, 0) << rig.err;
  const auto ran = gyrotherm_with("run tests/profiles/ten-seconds.toml --json --rig " + (folder / "rig.toml") +
                                  " --out " + (folder / "run.db"));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("{\"acknowledged\": 9}"), std::string::npos) << ran.out;
  return nlohmann::json::parse(gyrotherm_with("status --json " + (folder / "run.db")).out, nullptr, false);
}

std::string find_pty(const std::string& instrument, const std::string& output) {
  std::smatch match;
  return std::regex_search(output, match, std::regex(instrument + R"( +(serial:/dev/pts/\d+))")) ? match[1].str() : "";
}

/// Returns the default rig with some of its text replaced and absolute paths.
std::string changed_rig(const std::string& from, const std::string& to, const std::string& instead) {
  auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml").value();
  const auto begin = text.find(from), end = text.find(to);
  text.replace(begin, end - begin, instead);
  const std::string profiles = GYROTHERM_SOURCE_DIR "/profiles/";
  for (auto at = text.find("\"../"); at != std::string::npos; at = text.find("\"../", at))
    text.replace(at, 4, "\"" + profiles);
  return text;
}

TEST(Simulate, ServesRealRigOnPseudoTerminals) {
  const Folder folder;
  std::ofstream(folder / "virtual.toml") << changed_rig(
      "map = ", "line = ", "map = \"../chambers/watlow_f4t.toml\"\nframing = \"rtu\"\n");
  Background simulate({"simulate", "--pty", "--rig", folder / "virtual.toml"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro           serial:", 20)) << simulate.output();
  const auto output = simulate.output();
  const auto status =
      status_after_ten_seconds(folder, folder / "virtual.toml",
                               find_pty("chamber", output) + " " + find_pty("thermometer 1", output) + " " +
                                   find_pty("thermometer 2", output) + " " + find_pty("gyro", output));
  EXPECT_EQ(status["faults"], 0) << status.dump();
}

TEST(Simulate, LosesNoneOfThousandFramesPerSecond) {
  const Folder folder;
  std::ofstream(folder / "virtual.toml") << changed_rig(
      "[gyro]", "[analysis]",
      "[gyro]\nline = \"virtual\"\nlatitude = 45.0\nstream = \"../gyro-streams/kvh-17xx-b.toml\"\n\n");
  Background simulate({"simulate", "--full-rate", "--rig", folder / "virtual.toml"}, folder / "log");
  ASSERT_TRUE(simulate.wait_for("gyro", 20)) << simulate.output();
  const auto output = simulate.output();
  const auto status =
      status_after_ten_seconds(folder, folder / "virtual.toml",
                               find_port("chamber", output) + " " + find_port("thermometer 1", output) + " " +
                                   find_port("thermometer 2", output) + " " + find_port("gyro", output));
  EXPECT_EQ(status["faults"], 0) << status.dump();
  EXPECT_EQ(status["frames"]["lost"], 0) << status.dump();
  EXPECT_GT(status["frames"]["seen"], 9000) << status.dump();
}

}  // namespace
}  // namespace gyrotherm::app
