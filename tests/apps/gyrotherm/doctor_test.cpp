// SPDX-License-Identifier: Apache-2.0
/// Findings of the doctor, their fixes, and the exit code.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "tests/apps/gyrotherm/listener.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

using Json = nlohmann::json;

/// Returns the findings by their subject.
std::map<std::string, Json> parse_findings(const Ran& ran) {
  std::map<std::string, Json> findings;
  const auto document = Json::parse(ran.out, nullptr, false);
  if (document.is_discarded()) return findings;
  EXPECT_EQ(document.at("schema"), "gyrotherm-doctor/1");
  for (const auto& finding : document.at("findings")) findings[finding.at("what").get<std::string>()] = finding;
  return findings;
}

/// Expects a fix for each finding that is not ok, and for no other.
void expect_fixes(const std::map<std::string, Json>& findings) {
  for (const auto& [what, finding] : findings)
    EXPECT_EQ(finding.at("state") != "ok", finding.at("fix") != "") << finding.dump();
}

TEST(Doctor, ChecksMachineAndGivesFixes) {
  const Folder folder;
  const auto ran = gyrotherm_with("doctor --json --folder '" + (folder / "") + "'");
  const auto findings = parse_findings(ran);
  for (const auto* what : {"shipped files", "gyrotherm-make-safe", "folder", "disk", "file system", "clock",
                           "open files", "file size", "processor time", "memory", "locked memory", "priority"})
    EXPECT_TRUE(findings.contains(what)) << what << ran.out << ran.err;
  expect_fixes(findings);
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(gyrotherm_with("doctor").out.find("ok       disk"), std::string::npos);
}

TEST(Doctor, FindsLimitsThatEndRun) {
  const auto files = shell("ulimit -n 64; gyrotherm doctor --json");
  EXPECT_EQ(parse_findings(files).at("open files").at("state"), "warning");
  EXPECT_EQ(files.exit_code, 0);
  const auto size = shell("ulimit -f 100000; gyrotherm doctor --json");
  EXPECT_EQ(parse_findings(size).at("file size").at("state"), "fault");
  EXPECT_EQ(size.exit_code, 4);
  EXPECT_EQ(parse_findings(shell("ulimit -t 3600; gyrotherm doctor --json")).at("processor time").at("state"), "fault");
  const auto nice = parse_findings(shell("nice -n 7 " GYROTHERM_PROGRAM " doctor --json"));
  EXPECT_EQ(nice.at("priority").at("state"), "warning");
  expect_fixes(nice);
}

TEST(Doctor, FindsUnsuitableDisks) {
  const auto memory = gyrotherm_with("doctor --json --folder /dev/shm");
  EXPECT_EQ(parse_findings(memory).at("file system").at("state"), "warning") << memory.out;
  const auto nowhere = gyrotherm_with("doctor --json --folder /nowhere");
  EXPECT_EQ(parse_findings(nowhere).at("disk").at("state"), "fault");
  EXPECT_EQ(nowhere.exit_code, 4);
  const auto file = gyrotherm_with("doctor --json --folder README.md");
  EXPECT_EQ(parse_findings(file).at("folder").at("found"), "README.md is not a folder");
  EXPECT_EQ(file.exit_code, 4);
  const auto kernel = gyrotherm_with("doctor --json --folder /proc/self");
  EXPECT_EQ(kernel.exit_code, 4) << kernel.out;
  expect_fixes(parse_findings(kernel));
}

TEST(Doctor, ChecksLinesOfRig) {
  const auto simulated = gyrotherm_with("doctor --json --rig virtual");
  EXPECT_EQ(parse_findings(simulated).at("lines").at("found"), "virtual");
  const Folder folder;
  const auto missing = shell(
      "sed 's#tcp://[0-9.]*:502#tcp://127.0.0.1:9#' "
      "profiles/rigs/example-f4t-lakeshore-kvh.toml > '" +
      (folder / "rig.toml") + "'; gyrotherm doctor --json --rig '" + (folder / "rig.toml") + "'");
  const auto findings = parse_findings(missing);
  EXPECT_EQ(missing.exit_code, 3) << missing.err;
  EXPECT_EQ(findings.at("chamber").at("state"), "fault");
  EXPECT_NE(findings.at("chamber").at("found").get<std::string>().find("127.0.0.1:9"), std::string::npos);
  EXPECT_NE(findings.at("thermometer 1").at("found").get<std::string>().find("does not exist"), std::string::npos);
  expect_fixes(findings);
  EXPECT_EQ(gyrotherm_with("doctor --rig profiles/qualification.toml").exit_code, 4);
}

TEST(Doctor, ChecksProgramsThatDisturbSerialAdapters) {
  const auto findings = parse_findings(gyrotherm_with("doctor --json"));
  EXPECT_TRUE(findings.contains("ModemManager"));
  EXPECT_TRUE(findings.contains("brltty"));
  expect_fixes(findings);
}

/// Edits a shipped real rig and returns the doctor's findings.
std::map<std::string, Json> findings_for_rig(const Folder& folder, const std::string& edits) {
  return parse_findings(shell("sed " + edits + " profiles/rigs/example-f4t-lakeshore-kvh.toml > '" +
                              (folder / "rig.toml") + "'; gyrotherm doctor --json --rig '" + (folder / "rig.toml") +
                              "'"));
}

TEST(Doctor, ChecksCalibrationsAndDeviceNames) {
  const Folder folder;
  const std::string offline = "-e 's#tcp://[0-9.]*:502#tcp://127.0.0.1:9#' ";
  const auto valid = findings_for_rig(folder, offline + "-e 's/^due = .*/due = \"2199-01-01\"/'");
  EXPECT_EQ(valid.at("calibrations").at("state"), "ok");
  const auto overdue = findings_for_rig(
      folder, offline + "-e 's/^due = .*/due = \"2020-01-01\"/; s/^calibrated = .*/calibrated = \"2019-01-01\"/'");
  EXPECT_EQ(overdue.at("calibrations").at("state"), "warning");
  expect_fixes(overdue);
  const auto check = shell("gyrotherm check --json --rig '" + (folder / "rig.toml") + "'");
  EXPECT_FALSE(Json::parse(check.out).at("rig").at("overdue").empty()) << "check finds the same";
  EXPECT_TRUE(Json::parse(check.out).at("rig").at("unstable_names").empty());
}

TEST(Doctor, WritesNothingToChamber) {
  const Folder folder;
  const Listener chamber;
  const auto ran = shell("sed 's#tcp://[0-9.]*:502#tcp://127.0.0.1:" + std::to_string(chamber.port()) +
                         "#' profiles/rigs/example-f4t-lakeshore-kvh.toml > '" + (folder / "rig.toml") +
                         "'; gyrotherm doctor --json --rig '" + (folder / "rig.toml") + "'");
  EXPECT_EQ(parse_findings(ran).at("chamber").at("state"), "ok") << ran.out << ran.err;
  EXPECT_EQ(chamber.bytes_of_first_client(), 0);
}

}  // namespace
}  // namespace gyrotherm::app
