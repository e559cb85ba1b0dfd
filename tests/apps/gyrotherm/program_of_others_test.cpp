// SPDX-License-Identifier: Apache-2.0
/// Thermometer of a real rig with a third-party program as its driver: checked, run, and lost for a while.
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "acquisition/record/record.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/real_rig.hpp"

namespace gyrotherm::app {
namespace {

/// Dies when a file "die" exists, and appends its process id to "pids" at each start.
constexpr const char* kProgram = R"(#!/bin/sh
echo $$ >> pids
while read number word; do
  case $word in
    hello) echo "$number gyrotherm-thermometer/1 1 Acme T-1 0815";;
    read) [ -e die ] && { rm die; echo "the port is gone" >&2; exit 3; }
      echo "$number 20.5";;
  esac
done
)";

class ProgramOfOthers : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(laboratory.serves());
    ::setenv("XDG_STATE_HOME", (folder / "state").c_str(), 1);
    std::ofstream(folder / "acme.sh") << kProgram;
    std::filesystem::permissions(folder / "acme.sh", std::filesystem::perms::owner_all);
    auto text = read_text_file(laboratory.rig()).value();
    const auto channels = text.find(R"(channels = ["shell"])");
    ASSERT_NE(channels, std::string::npos);
    const auto begin = text.rfind("[[thermometer]]", channels);
    text.replace(begin, channels - begin, "[[thermometer]]\ndriver = \"process\"\ncommand = [\"./acme.sh\"]\n");
    std::ofstream(rig) << text;
  }
  void TearDown() override { ::unsetenv("XDG_STATE_HOME"); }
  /// Records a few seconds with a rig file in "rigs", which runs the program there, "acme.sh", by `words`. Leaves an
  /// unfinished record in "runs" and the program's "pids" in "rigs".
  void record_from_rigs(const std::string& words) {
    std::filesystem::create_directories(folder / "rigs");
    std::filesystem::create_directories(folder / "runs");
    std::filesystem::copy(folder / "acme.sh", folder / "rigs/acme.sh",
                          std::filesystem::copy_options::overwrite_existing);
    auto text = read_text_file(rig).value();
    const std::string old = R"(command = ["./acme.sh"])";
    text.replace(text.find(old), old.size(), "command = " + words);
    std::ofstream(folder / "rigs/rig.toml") << text;
    Background run(
        {"run", "tests/profiles/ten-minutes-warm.toml", "--rig", folder / "rigs/rig.toml", "--out", stopped, "--json"},
        new_log());
    ASSERT_TRUE(run.wait_for("\"acknowledged\": 2}", 60)) << run.output();
    run.signal(SIGINT);
    ASSERT_EQ(run.wait(), 5) << run.output();
  }
  /// Resumes the record and returns whether it continues. Stores the program's messages in `output`.
  [[nodiscard]] bool resume_continues(const std::string& path, const std::vector<std::string>& options,
                                      std::string& output) {
    std::vector<std::string> words{"resume", path, "--json"};
    words.insert(words.end(), options.begin(), options.end());
    Background resumed(words, new_log());
    const bool goes_on = resumed.wait_for("acknowledged", 60);
    resumed.signal(SIGINT);
    const bool interrupted = resumed.wait() == 5;
    output = resumed.output();
    return goes_on && interrupted;
  }
  /// Returns the name of a new file.
  [[nodiscard]] std::string new_log() { return folder / ("log" + std::to_string(++logs)); }
  /// Executes SQL on a record without a new hash chain.
  static void edit(const std::string& path, const std::string& sql) {
    auto database = record::Database::open(path, record::Access::read_write, 1000);
    ASSERT_TRUE(database) << text(database.error());
    const auto done = database->execute(sql);
    ASSERT_TRUE(done) << text(done.error());
  }

  /// Returns the ids of all processes that the program ever was.
  [[nodiscard]] std::set<pid_t> pids() const {
    std::set<pid_t> all;
    std::ifstream file(folder / "pids");
    for (pid_t one = 0; file >> one;) all.insert(one);
    return all;
  }

  int logs = 0;
  const Folder folder;
  const RealLaboratory laboratory{folder / ""};
  const std::string rig = folder / "program.toml", record = folder / "run.db", stopped = folder / "runs/r.db";
};

TEST_F(ProgramOfOthers, IsRunByCheckOnlyToConnect) {
  const auto checked = gyrotherm_with("check --rig " + rig);
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_NE(checked.out.find("shell: read by the program ./acme.sh"), std::string::npos) << checked.out;
  const auto looked = gyrotherm_with("doctor --rig " + rig);
  EXPECT_NE(looked.out.find("acme.sh is executable"), std::string::npos) << looked.out << looked.err;
  EXPECT_TRUE(pids().empty()) << "neither command has started it";
  const auto connected = gyrotherm_with("check --connect --rig " + rig);
  EXPECT_EQ(connected.exit_code, 0) << connected.err;
  EXPECT_NE(connected.out.find("Acme T-1 0815"), std::string::npos) << connected.out;
  EXPECT_FALSE(pids().empty());
  for (const auto pid : pids()) EXPECT_NE(::kill(pid, 0), 0) << "it is left";
}

TEST_F(ProgramOfOthers, IsReportedByDoctorWhenNotExecutable) {
  std::filesystem::permissions(folder / "acme.sh", std::filesystem::perms::owner_read);
  const auto looked = gyrotherm_with("doctor --rig " + rig);
  EXPECT_EQ(looked.exit_code, 3) << looked.out;
  EXPECT_NE(looked.out.find("is not a program that this user may run"), std::string::npos) << looked.out;
}

TEST_F(ProgramOfOthers, CausesOnlyChannelFaultWhenItDies) {
  Background run({"run", "tests/profiles/ten-minutes-warm.toml", "--rig", rig, "--out", record, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 2}", 60)) << run.output();
  std::ofstream(folder / "die") << "now\n";
  const auto reached = last_acknowledged(run.output()) + 6;
  EXPECT_TRUE(run.wait_for("\"acknowledged\": " + std::to_string(reached) + "}", 60)) << run.output();
  run.signal(SIGINT);
  EXPECT_EQ(run.wait(), 5) << run.output();
  EXPECT_GE(pids().size(), 2u) << "it was started again";
  for (const auto pid : pids()) EXPECT_NE(::kill(pid, 0), 0) << "it is left";
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  std::string events;
  for (const auto& stored : kept->events) events += stored.event.text + "\n";
  for (const auto* part : {"the program ended with exit code 3; its last output was \"the port is gone\""})
    EXPECT_NE(events.find(part), std::string::npos) << part << " in\n" << events;
  EXPECT_EQ(kept->thermometers_c.back().back(), 20.5) << "and reads again";
  EXPECT_GE(kept->slot.size(), static_cast<std::size_t>(reached));
}

constexpr const char* kRelative = R"(["./acme.sh"])";

TEST_F(ProgramOfOthers, ResumesWithOriginalRelativePaths) {
  for (const auto* words : {R"(["/bin/sh", "acme.sh"])", kRelative, R"(["../rigs/acme.sh"])"}) {
    record_from_rigs(words);
    std::string output;
    EXPECT_TRUE(resume_continues(stopped, {}, output)) << words << output;
    const auto archive = folder / "archive";
    std::filesystem::rename(folder / "runs", archive);
    EXPECT_TRUE(resume_continues(archive + "/r.db", {"--accept"}, output)) << "after the record was moved: " << output;
    std::filesystem::remove_all(archive);
  }
}

TEST_F(ProgramOfOthers, IsNotStartedFromChangedRecord) {
  record_from_rigs(kRelative);
  const auto evil = folder / "evil";
  std::filesystem::remove(folder / "rigs/pids");
  const std::vector<std::string> edits{
      "UPDATE meta SET value = replace(value, './acme.sh', '/bin/sh\", \"-c\", \"touch " + evil +
          "') WHERE key = 'rig_text'",
      "UPDATE meta SET value = '" + (folder / "runs/rig.toml") + "' WHERE key = 'rig_file'",
      "UPDATE meta SET value = value || ' ' WHERE key = 'chamber_map_text'",
      "UPDATE meta SET value = value || ' ' WHERE key = 'profile_text'",
      "UPDATE sample SET chamber_air_c = 21 WHERE slot = 1",
      "UPDATE event SET text = 'all is well' WHERE id = (SELECT min(id) FROM event)",
  };
  for (std::size_t i = 0; i < edits.size(); ++i) {
    const auto copy = folder / ("runs/copy" + std::to_string(i) + ".db");
    std::filesystem::copy(stopped, copy);
    std::filesystem::copy(stopped + ".status", copy + ".status");
    edit(copy, edits[i]);
    const auto resumed = shell("timeout 60 " GYROTHERM_PROGRAM " resume --accept --trust-commands " + copy);
    EXPECT_EQ(resumed.exit_code, 4) << edits[i] << "\n" << resumed.err;
    EXPECT_FALSE(std::filesystem::exists(evil)) << edits[i];
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "rigs/pids")) << "the program was started";
}

/// Writes a record with a valid chain and another rig.
void write_forged_record(const std::string& from, const std::string& to, const std::string& rig_text,
                         const std::string& rig_file) {
  auto info = record::read_info(from);
  ASSERT_TRUE(info) << text(info.error());
  info->rig_text = rig_text;
  info->rig_file = rig_file;
  auto file = record::RunFile::create(to, *info);
  ASSERT_TRUE(file) << text(file.error());
}

TEST_F(ProgramOfOthers, IsNotStartedFromForgedRecord) {
  record_from_rigs(kRelative);
  const auto evil = folder / "evil";
  const auto rig_file = folder / "rigs/rig.toml";
  const auto rig_text = record::read_info(stopped).value().rig_text;
  const auto with = [&](const std::string& command) {
    auto text = rig_text;
    const auto at = text.find(kRelative);
    return text.replace(at, std::string(kRelative).size(), command);
  };
  const auto touch = "[\"/bin/sh\", \"-c\", \"touch " + evil + "\"]";
  std::ofstream(folder / "runs/acme.sh") << "#!/bin/sh\ntouch " + evil + "\n";
  std::filesystem::permissions(folder / "runs/acme.sh", std::filesystem::perms::owner_all);
  std::ofstream(folder / "runs/rig.toml") << rig_text;  // same text as the real file
  const std::vector<std::pair<std::string, std::string>> forgeries{
      {with(touch), rig_file},
      {with(touch), ""},
      {rig_text, ""},
      {rig_text, folder / "runs/rig.toml"},
      {with(R"(["./acme.sh", "--other"])"), rig_file},
      {with(R"(["../runs/acme.sh"])"), rig_file},
  };
  for (std::size_t i = 0; i < forgeries.size(); ++i) {
    const auto copy = folder / ("runs/forged" + std::to_string(i) + ".db");
    write_forged_record(stopped, copy, forgeries[i].first, forgeries[i].second);
    const auto resumed = shell("timeout 60 " GYROTHERM_PROGRAM " resume --accept " + copy);
    EXPECT_EQ(resumed.exit_code, 3) << i << resumed.err;
    EXPECT_NE(resumed.err.find("not started: this user has not confirmed it"), std::string::npos) << resumed.err;
    EXPECT_FALSE(std::filesystem::exists(evil)) << i;
  }
}

TEST_F(ProgramOfOthers, IsStartedByResumeOnlyAsConfirmed) {
  record_from_rigs(R"(["/bin/sh", "acme.sh", "--port", "1"])");
  const auto expect_refused = [&](const char* why) {
    const auto resumed = shell("timeout 60 " GYROTHERM_PROGRAM " resume --accept " + stopped);
    EXPECT_EQ(resumed.exit_code, 3) << why;
    EXPECT_NE(resumed.err.find(why), std::string::npos) << resumed.err;
    EXPECT_NE(resumed.err.find("--trust-commands"), std::string::npos) << resumed.err;
  };
  ::setenv("XDG_STATE_HOME", (folder / "state-of-another").c_str(), 1);
  expect_refused("this user has not confirmed it");
  ::setenv("XDG_STATE_HOME", (folder / "state").c_str(), 1);
  std::ofstream(folder / "rigs/acme.sh", std::ios::app) << "# changed\n";
  expect_refused("has changed since it was confirmed");
  std::string output;
  EXPECT_TRUE(resume_continues(stopped, {"--accept", "--trust-commands"}, output)) << output;
  EXPECT_TRUE(resume_continues(stopped, {"--accept"}, output)) << "a trusted command is confirmed: " << output;
  const auto confirmed = folder / "state/gyrotherm/confirmed-commands";
  std::filesystem::permissions(confirmed, std::filesystem::perms::all);
  expect_refused("is writable by users other than its owner");
  std::filesystem::permissions(confirmed, std::filesystem::perms::owner_all);
  for (const auto& file : list_folder(confirmed)) {
    std::filesystem::rename(file, folder / "moved");
    std::filesystem::create_symlink(folder / "moved", file);
  }
  expect_refused("this user has not confirmed it");
}

TEST_F(ProgramOfOthers, IsResumedOnlyByAcceptAfterRestartOfMachine) {
  record_from_rigs(kRelative);
  auto status = read_text_file(stopped + ".status").value();
  ASSERT_NE(status.find(boot_id()), std::string::npos) << status;
  for (auto at = status.find(boot_id()); at != std::string::npos; at = status.find(boot_id()))
    status.replace(at, 8, "00000000");
  std::ofstream(stopped + ".status") << status;
  const auto asked = shell("timeout 60 " GYROTHERM_PROGRAM " resume " + stopped);
  EXPECT_EQ(asked.exit_code, 5) << asked.err;
  EXPECT_NE(asked.err.find("--accept"), std::string::npos) << asked.err;
  std::string output;
  EXPECT_TRUE(resume_continues(stopped, {"--accept"}, output)) << output;
}

}  // namespace
}  // namespace gyrotherm::app
