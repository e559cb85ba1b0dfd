// SPDX-License-Identifier: Apache-2.0
/// The shipped unit: systemd accepts it, and it is well confined.
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <regex>

#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_file.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// Writes the unit as installed, with the programs under test. Returns its path.
std::string write_unit(const Folder& folder) {
  auto text = read_text_file(GYROTHERM_SOURCE_DIR "/apps/gyrotherm/systemd/gyrotherm@.service.in").value();
  const auto programs = std::filesystem::path(GYROTHERM_PROGRAM).parent_path().string();
  text = std::regex_replace(text, std::regex("@GYROTHERM_BIN@"), programs);
  text = std::regex_replace(text, std::regex("@GYROTHERM_DOCS@"), "/usr/share/doc/gyrotherm");
  const auto path = folder / "gyrotherm@.service";
  std::ofstream(path) << text;
  return path;
}

TEST(SystemdUnit, PassesSystemdVerification) {
  if (!installed("systemd-analyze")) GTEST_SKIP() << "systemd-analyze is not installed";
  const Folder folder;
  const auto verified = shell("systemd-analyze verify --man=no " + write_unit(folder) + " 2>&1 | grep gyrotherm@");
  EXPECT_EQ(verified.out, "");
}

TEST(SystemdUnit, IsConfined) {
  if (!installed("systemd-analyze")) GTEST_SKIP() << "systemd-analyze is not installed";
  const Folder folder;
  const auto judged = shell("systemd-analyze security --offline=true --threshold=20 --no-pager " + write_unit(folder));
  EXPECT_EQ(judged.exit_code, 0) << judged.out << judged.err;
}

TEST(SystemdUnit, LimitsTotalTimeToTwentySeconds) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/apps/gyrotherm/systemd/gyrotherm@.service.in").value();
  const auto seconds = [&](const std::string& key) {
    std::smatch match;
    return std::regex_search(text, match, std::regex("\n" + key + "=(\\d+)\n")) ? std::stoi(match[1]) : 1000;
  };
  EXPECT_LE(seconds("WatchdogSec") + seconds("TimeoutAbortSec") + 10, 20);
  EXPECT_GE(seconds("TimeoutStopSec"), 10) << "time for make-safe";
}

/// Returns the command that ExecStopPost starts for the run "rate" on a machine in that state. The programs here only
/// print.
std::string stop_command(const Folder& folder, const std::string& state) {
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"systemctl", "echo " + state},
                                   {"gyrotherm-make-safe", "echo \"$@\""},
                                   {"timeout", "echo within $1 s; shift; exec \"$@\""}}) {
    std::ofstream(folder / name) << "#!/bin/sh\n" << text << "\n";
    std::filesystem::permissions(folder / name, std::filesystem::perms::owner_all);
  }
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/apps/gyrotherm/systemd/gyrotherm@.service.in").value();
  std::smatch command;
  EXPECT_TRUE(std::regex_search(text, command, std::regex("\nExecStopPost=(.*)\n")));
  const auto line = std::regex_replace(command[1].str(), std::regex("@GYROTHERM_BIN@"), folder / ".");
  return shell("PATH='" + (folder / ".") + "':$PATH; " + std::regex_replace(line, std::regex("%i"), "rate")).out;
}

TEST(SystemdUnit, LimitsMakeSafeOnlyAtShutdown) {
  const Folder folder;
  EXPECT_EQ(stop_command(folder, "stopping"), "within 30 s\n--kill rate.db\n");
  for (const auto* state : {"running", "degraded", "starting", "maintenance", "offline", "''"})
    EXPECT_EQ(stop_command(folder, state), "--insist rate.db\n") << state;
}

/// Returns the exit code of ExecCondition for the run "rate" in this folder. 0 starts the run; 1 to 254 skips it
/// without a failure.
int run_condition(const Folder& folder) {
  const auto text = read_text_file(write_unit(folder)).value();
  std::smatch line;
  if (!std::regex_search(text, line, std::regex("\nExecCondition=(/bin/sh -c '[^'\n]*')\n"))) return -1;
  const auto command = std::regex_replace(line[1].str(), std::regex("%i"), "rate");
  return shell("cd '" + (folder / ".") + "' && " + command).exit_code;
}

TEST(SystemdUnit, SkipsFinishedRunWithoutFailure) {
  const Folder folder;
  const auto record = folder / "rate.db";
  EXPECT_EQ(run_condition(folder), 0) << "no record: the run begins";
  Background run({"run", "profiles/random.toml", "--rig", "profiles/rigs/virtual.toml", "--out", record, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("acknowledged", 60));
  run.signal(SIGINT);
  ASSERT_EQ(run.wait(), 5) << run.output();
  EXPECT_EQ(run_condition(folder), 0) << "an interrupted run continues";
  const auto resumed = gyrotherm_with("resume " + record);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(gyrotherm_with("resume " + record).exit_code, 2) << "which would be a failed unit";
  EXPECT_EQ(run_condition(folder), 1);
}

/// Writes the second file of a run that continued after rate.db was removed.
void leave_second_file(const Folder& folder) {
  record::RunInfo info;
  info.id = "0123456789abcdef0123456789abcdef";
  info.virtual_rig = true;
  const record::Continuation continuation{.part = 2, .before = "rate.db", .from = 0, .cause = "rate.db was removed"};
  auto file = record::RunFile::create(folder / "rate.2.db", info, continuation);
  ASSERT_TRUE(file) << text(file.error());
  ASSERT_TRUE(file->begin() && file->insert_event(-1, {{}, EventKind::fault, "goes on"}) && file->replace_frames({}) &&
              file->commit());
}

/// Returns the start command of the run "rate". The program only prints its arguments, except for "status".
std::string start_command(const Folder& folder) {
  std::ofstream(folder / "gyrotherm") << "#!/bin/sh\n[ \"$1\" = status ] && exec " GYROTHERM_PROGRAM
                                         " \"$@\"\necho \"$@\"\n";
  std::filesystem::permissions(folder / "gyrotherm", std::filesystem::perms::owner_all);
  auto text = read_text_file(GYROTHERM_SOURCE_DIR "/apps/gyrotherm/systemd/gyrotherm@.service.in").value();
  std::smatch command;
  EXPECT_TRUE(std::regex_search(text, command, std::regex("\nExecStart=(.*)\n")));
  auto line = std::regex_replace(command[1].str(), std::regex("@GYROTHERM_BIN@"), folder / ".");
  return "cd " + (folder / ".") + "; export PROFILE=day.toml RIG=lab.toml; " +
         std::regex_replace(line, std::regex("%i"), "rate");
}

TEST(SystemdUnit, ResumesExistingRun) {
  const Folder folder;
  const auto command = start_command(folder);
  const std::string begins = "run day.toml --rig lab.toml --out rate.db\n", goes_on = "resume rate.db\n";
  EXPECT_EQ(shell(command).out, begins);
  std::ofstream(folder / "rate.2.db") << "somebody's";
  EXPECT_EQ(shell(command).out, begins) << "not a part of a run";
  std::filesystem::remove(folder / "rate.2.db");
  leave_second_file(folder);
  EXPECT_EQ(shell(command).out, goes_on);
  const auto anew = gyrotherm_with("run tests/profiles/short-rate.toml --rig profiles/rigs/virtual.toml --out " +
                                   (folder / "rate.db"));
  EXPECT_EQ(anew.exit_code, 4) << anew.err;
  EXPECT_NE(anew.err.find("its run continues in " + (folder / "rate.2.db")), std::string::npos) << anew.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "rate.db"));
  std::filesystem::remove(folder / "rate.2.db");
  std::ofstream(folder / "rate.db") << "damaged";
  EXPECT_EQ(shell(command).out, goes_on) << "and resume reports what is wrong with it";
}

}  // namespace
}  // namespace gyrotherm::app
