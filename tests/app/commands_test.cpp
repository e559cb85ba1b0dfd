// SPDX-License-Identifier: Apache-2.0
/// What a user can rely on at the command line: exit codes, places of mistakes, suggestions.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/program.hpp"

namespace gyrotherm::app {
namespace {

TEST(CommandLine, AMisspeltCommandIsAnsweredWithTheNearestOne) {
  const auto ran = gyrotherm_with("qualifi --out x");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("Did you mean \"qualify\"?"), std::string::npos) << ran.err;
}

TEST(CommandLine, NoCommandAndUnknownOptionsAreUsageErrors) {
  EXPECT_EQ(gyrotherm_with("").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("check --colour").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("check").exit_code, 2);
  EXPECT_EQ(gyrotherm_with("train").exit_code, 2);
}

TEST(CommandLine, HelpOfEachCommandOpensWithAnExample) {
  for (const auto* command :
       {"qualify", "run", "go", "resume", "status", "simulate", "check", "import", "export", "train", "verify",
        "type-prior", "compensate", "fuse", "export-model", "reduce", "report", "doctor", "completion"}) {
    const auto ran = gyrotherm_with(std::string(command) + " --help");
    EXPECT_EQ(ran.exit_code, 0) << command;
    EXPECT_TRUE(ran.out.starts_with("Example: gyrotherm " + std::string(command))) << ran.out;
  }
}

TEST(Check, PrintsTheArithmeticOfTheRateProgram) {
  const auto ran = gyrotherm_with("check profiles/qualification.toml --rig profiles/rigs/virtual.toml");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* figure : {"672", "552", "512", "480", "2216"})
    EXPECT_NE(ran.out.find(figure), std::string::npos) << figure;
}

TEST(Check, AProfileBeyondTheChamberIsRefusedWithItsPlace) {
  const Folder folder;
  std::ofstream(folder / "hot.toml") << "schema = \"gyrotherm-profile/1\"\nname = \"hot\"\n\n[[segment]]\nkind = "
                                        "\"hold\"\nat = \"150 °C\"\ntime = \"1 h\"\n";
  const auto ran = gyrotherm_with("check " + (folder / "hot.toml") + " --rig profiles/rigs/virtual.toml");
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("hot.toml:4:1"), std::string::npos) << ran.err;
}

TEST(Check, AVirtualRigIsRefusedAsARunWouldRefuseIt) {
  const Folder folder;
  const auto rig = folder / "rig.toml";
  const auto ran =
      shell("sed 's/\"shell\"/\"outside\"/g; s|\"\\.\\./|\"'$PWD'/profiles/|' profiles/rigs/virtual.toml > " + rig +
            "; gyrotherm check --rig " + rig);
  EXPECT_EQ(ran.exit_code, 4) << ran.out;
  EXPECT_NE(ran.err.find("channel \"outside\" is none of A, B"), std::string::npos) << ran.err;
}

TEST(Check, ASoakOnASensorThatTheRigDoesNotHaveIsRefusedBeforeAnythingMoves) {
  const Folder folder;
  std::ofstream(folder / "soak.toml")
      << "schema = \"gyrotherm-profile/1\"\nname = \"soak\"\n\n[[segment]]\nkind = "
         "\"hold\"\nat = \"20 °C\"\ntime = \"1 min\"\n\n[[segment]]\nkind = \"hold\"\n"
         "at = \"150 °C\"\ntime = \"1 min\"\nguaranteed_soak = true\nsoak_sensor = \"Z\"\n";
  const auto profile = folder / "soak.toml", record = folder / "soak.db";
  EXPECT_EQ(gyrotherm_with("check " + profile).exit_code, 0) << "by itself it is well";
  for (const auto& command : {"check " + profile, "run " + profile + " --out " + record}) {
    const auto ran = gyrotherm_with(command + " --rig profiles/rigs/virtual.toml");
    EXPECT_EQ(ran.exit_code, 4) << command;
    EXPECT_NE(ran.err.find("soak.toml:9:1: soak_sensor is \"Z\", expected \"air\" or a channel"), std::string::npos)
        << ran.err;
    EXPECT_NE(ran.err.find("150 °C is beyond the chamber"), std::string::npos) << "and the other mistake: " << ran.err;
  }
  EXPECT_FALSE(std::filesystem::exists(record));
}

TEST(Check, AllMistakesOfAFileAreToldAtOnce) {
  const Folder folder;
  std::ofstream(folder / "bad.toml") << "schema = \"gyrotherm-profile/1\"\nnaem = \"x\"\n\n[[segment]]\nkind = "
                                        "\"hold\"\nat = 20\ntime = \"1 fortnight\"\n";
  const auto ran = gyrotherm_with("check " + (folder / "bad.toml"));
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("bad.toml:2:1"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("bad.toml:7:8"), std::string::npos) << ran.err;
}

TEST(Check, ConnectAsksEveryInstrumentOfTheVirtualRig) {
  const auto ran = gyrotherm_with("check --rig profiles/rigs/virtual.toml --connect");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* word : {"chamber:", "LSCI,MODEL218", "gyro:"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << ran.out;
}

TEST(Check, ConnectTimesEveryInstrumentOfMixedOnes) {
  const auto ran = gyrotherm_with("check --rig profiles/rigs/virtual-mixed.toml --connect");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* word : {"word order cdab", "USB-TEMP", "10 reads: ", "2 frames seen, 0 lost, 0 bad"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << ran.out;
}

TEST(Check, SaysHowSureTheFilesAreAndWhichCalibrationIsDue) {
  const Folder folder;
  const auto ran = shell("sed -e 's#\\.\\./#" GYROTHERM_SOURCE_DIR
                         "/profiles/#; s#2027-01-18#2020-01-18#' profiles/rigs/example-f4t-lakeshore-kvh.toml > " +
                         (folder / "rig.toml") + " && gyrotherm check --rig " + (folder / "rig.toml"));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* word :
       {"description: verified, from DSP-3000 manual", "WARNING: calibration of B", "from the manual",
        "polynomial 0.0031, 0.99987, 1.2e-06, certificate K-2026-0118, due 2020-01-18"})
    EXPECT_NE(ran.out.find(word), std::string::npos) << ran.out;
}

TEST(Check, FindingsAreOneJsonDocument) {
  const auto ran =
      gyrotherm_with("check profiles/qualification.toml --rig profiles/rigs/virtual.toml --connect --json");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto found = nlohmann::json::parse(ran.out);
  EXPECT_EQ(found["rig"]["simulated"], true);
  EXPECT_EQ(found["instruments"].size(), 4u);
  EXPECT_EQ(found["profile"]["all"]["seconds"], 221600);
  EXPECT_EQ(found["profile"]["all"]["clusters"], 2216);
}

TEST(Run, ARigThatIsNotThereIsAnInstrumentFault) {
  const Folder folder;
  auto rig =
      shell(
          "sed -e 's#\"virtual\"$#\"tcp://127.0.0.1:9\"#; s#= \"virtual\" .*#= \"tcp://127.0.0.1:9\"#; "
          "s#\\.\\./chambers#" GYROTHERM_SOURCE_DIR "/profiles/chambers#; /^\\[virtual/,$d' profiles/rigs/virtual.toml")
          .out;
  std::ofstream(folder / "rig.toml") << rig;
  const auto ran = gyrotherm_with("run tests/profiles/short-rate.toml --rig " + (folder / "rig.toml") + " --out " +
                                  (folder / "run.db"));
  EXPECT_EQ(ran.exit_code, 3) << ran.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db"));
}

TEST(Run, ARecordIsNeverOverwritten) {
  const Folder folder;
  std::ofstream(folder / "run.db") << "precious";
  const auto ran = gyrotherm_with("run tests/profiles/short-rate.toml --rig profiles/rigs/virtual.toml --out " +
                                  (folder / "run.db"));
  EXPECT_EQ(ran.exit_code, 4) << ran.err;
  EXPECT_EQ(shell("cat " + (folder / "run.db")).out, "precious");
}

}  // namespace
}  // namespace gyrotherm::app
