// SPDX-License-Identifier: Apache-2.0
/// Observation of an active run: its rows, its state and its alarms.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"

namespace gyrotherm::app {
namespace {

using nlohmann::json;
using std::chrono_literals::operator""ms;

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) lines.push_back(line);
  return lines;
}

/// Dry run of several minutes whose record is open to readers.
class LiveRun : public testing::Test {
 protected:
  LiveRun()
      : path_(folder_ / "run.db"),
        run_({"run", "profiles/qualification.toml", "--rig", "profiles/rigs/virtual.toml", "--out", path_,
              "--json=samples"},
             folder_ / "out") {
    for (int i = 0; i < 1000 && !std::filesystem::exists(folder_ / "run.live.db"); ++i)
      std::this_thread::sleep_for(20ms);
  }
  Folder folder_;
  std::string path_;
  Background run_;
};

TEST_F(LiveRun, ExportsRowsAsTheyArrive) {
  const auto followed = shell("gyrotherm export " + path_ + " --follow | head -200");
  const auto lines = split_lines(followed.out);
  ASSERT_EQ(lines.size(), 200u) << followed.err;
  EXPECT_TRUE(lines[0].starts_with("# SIMULATED")) << lines[0];
  const auto table = gyrotherm_with("export " + (folder_ / "run.live.db") + " --out " + (folder_ / "table.csv"));
  EXPECT_EQ(table.exit_code, 0) << table.err;
}

TEST_F(LiveRun, IsFollowedToEnd) {
  Background follower({"export", path_, "--follow"}, folder_ / "followed");
  ASSERT_TRUE(follower.wait_for("\n10,", 60));
  run_.signal(SIGINT);
  EXPECT_EQ(run_.wait(), 5);
  EXPECT_EQ(follower.wait(), 0) << follower.output();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run.live.db"));
  ASSERT_EQ(gyrotherm_with("export " + path_ + " --out " + (folder_ / "whole.csv")).exit_code, 0);
  EXPECT_EQ(follower.output(), shell("cat " + (folder_ / "whole.csv")).out) << "each row exactly once";
}

TEST_F(LiveRun, IsFollowedToLastRowWhenKilled) {
  Background follower({"export", path_, "--follow"}, folder_ / "followed");
  ASSERT_TRUE(follower.wait_for("\n10,", 60));
  run_.signal(SIGKILL);
  EXPECT_EQ(run_.wait(), -SIGKILL);
  EXPECT_EQ(follower.wait(), 0) << follower.output();
  ASSERT_EQ(gyrotherm_with("export " + path_ + " --out " + (folder_ / "whole.csv")).exit_code, 0);
  EXPECT_EQ(follower.output(), shell("cat " + (folder_ / "whole.csv")).out);
}

TEST_F(LiveRun, IsReadByPythonWhileActive) {
  if (!installed("python3")) GTEST_SKIP() << "no python3";
  const auto read = shell(
      "python3 - <<'END'\n"
      "import sqlite3, time\n"
      "live = sqlite3.connect('file:" +
      (folder_ / "run.live.db") +
      "?mode=ro', uri=True)\n"
      "until = time.monotonic() + 20\n"
      "rows = 0\n"
      "while rows <= 100 and time.monotonic() < until:\n"
      "    rows = live.execute('SELECT count(*) FROM sample').fetchone()[0]\n"
      "    time.sleep(0.05)\n"
      "print(rows)\n"
      "END");
  EXPECT_GT(std::atoi(read.out.c_str()), 100) << read.err;
}

TEST_F(LiveRun, PrintsStatusEachSecond) {
  const auto watched = shell("gyrotherm status " + path_ + " --watch --json | head -2");
  const auto lines = split_lines(watched.out);
  ASSERT_EQ(lines.size(), 2u) << watched.err;
  EXPECT_LT(json::parse(lines[0])["slot"], json::parse(lines[1])["slot"]);
  EXPECT_EQ(json::parse(lines[0])["alarms"], json::array());
  EXPECT_EQ(json::parse(lines[0])["live_copy_trouble"], "");
}

TEST_F(LiveRun, PrintsEachSecondCompletely) {
  ASSERT_TRUE(run_.wait_for("\"slot\":100,", 60)) << run_.output();
  const auto lines = split_lines(run_.output());
  ASSERT_GT(lines.size(), 100u);
  const auto second = json::parse(lines[0]);
  EXPECT_EQ(second["slot"], 0);
  EXPECT_EQ(second["state"], "execute");
  EXPECT_TRUE(second["thermometers_c"]["A"].is_number()) << lines[0];
  EXPECT_EQ(second["events"][0]["kind"], "started") << lines[0];
}

TEST_F(LiveRun, IsFoundByLinkToRecord) {
  const auto link = folder_ / "of today.db";
  std::filesystem::create_symlink("run.db", link);
  const auto told = gyrotherm_with("tell '" + link + "' note looked at by a link");
  EXPECT_EQ(told.exit_code, 0) << told.err;
  const auto status = gyrotherm_with("status '" + link + "'");
  EXPECT_NE(status.out.find(": running"), std::string::npos) << status.out;
  Background follower({"export", link, "--follow"}, folder_ / "followed");
  EXPECT_TRUE(follower.wait_for("\n10,", 60)) << follower.output();
}

TEST_F(LiveRun, IsFoundByNameOfLiveCopy) {
  const auto copy = folder_ / "run.live.db";
  const auto status = gyrotherm_with("status " + copy);
  EXPECT_NE(status.out.find("run.db: running"), std::string::npos) << status.out << status.err;
  Background follower({"export", copy, "--follow"}, folder_ / "followed");
  ASSERT_TRUE(follower.wait_for("\n10,", 60)) << follower.output();
  run_.signal(SIGSTOP);
  std::this_thread::sleep_for(3000ms);
  EXPECT_TRUE(follower.is_running()) << "the record is being written, although the copy is not";
  run_.signal(SIGCONT);
  run_.signal(SIGINT);
  EXPECT_EQ(run_.wait(), 5);
  EXPECT_EQ(follower.wait(), 0) << follower.output();
  ASSERT_EQ(gyrotherm_with("export " + path_ + " --out " + (folder_ / "whole.csv")).exit_code, 0);
  EXPECT_EQ(follower.output(), shell("cat " + (folder_ / "whole.csv")).out);
}

TEST_F(LiveRun, RefusesToAcknowledgeUnknownAlarm) {
  const auto unknown = gyrotherm_with("tell " + path_ + " acknowledge 9999 seen");
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_NE(unknown.err.find("there is no alarm 9999"), std::string::npos) << unknown.err;
  EXPECT_EQ(gyrotherm_with("tell " + path_ + " acknowledge 9999").exit_code, 2) << "a comment is required";
}

/// Records of two runs, one.db and two.db. The live copy of the first has the names for run.db and for run.
class CopyOfAnotherRun : public testing::Test {
 protected:
  CopyOfAnotherRun() {
    std::ofstream(folder_ / "map.toml") << small_map();
    for (const auto& [name, rows] : {std::pair("one", 40), std::pair("two", 90)}) {
      const auto file = folder_ / name;
      std::ofstream(file + ".csv") << small_rows(rows);
      const auto imported =
          gyrotherm_with("import " + file + ".csv --map " + (folder_ / "map.toml") + " --out " + file + ".db");
      EXPECT_EQ(imported.exit_code, 0) << imported.err;
    }
    link_copy_to("one", 1);
  }
  void link_copy_to(const std::string& name, int number) {
    const auto target = "run.live.db." + std::to_string(number);
    std::filesystem::copy_file(folder_ / (name + ".db"), folder_ / target);
    std::filesystem::create_symlink(target, folder_ / "run.live.db.new");
    std::filesystem::rename(folder_ / "run.live.db.new", folder_ / "run.live.db");
  }
  Folder folder_;
};

TEST_F(CopyOfAnotherRun, IsNotFollowed) {
  for (const auto* name : {"run.db", "run"}) {
    const auto record = folder_ / name, table = record + ".csv";
    std::filesystem::copy_file(folder_ / "two.db", record);
    const auto followed = gyrotherm_with("export " + record + " --follow");
    EXPECT_EQ(followed.exit_code, 0) << followed.err;
    ASSERT_EQ(gyrotherm_with("export " + record + " --out " + table).exit_code, 0);
    EXPECT_EQ(followed.out, shell("cat " + table).out) << name;
  }
}

TEST_F(CopyOfAnotherRun, AcceptsNoRequest) {
  std::filesystem::copy_file(folder_ / "two.db", folder_ / "run.db");
  const auto copy = gyrotherm_with("tell " + (folder_ / "run.live.db") + " pause");
  EXPECT_EQ(copy.exit_code, 2);
  EXPECT_NE(copy.err.find("is the live copy of a record, expected " + (folder_ / "run.db")), std::string::npos)
      << copy.err;
  const auto imported = gyrotherm_with("tell " + (folder_ / "two.db") + " note seen");
  EXPECT_EQ(imported.exit_code, 2);
  EXPECT_NE(imported.err.find("is an imported record"), std::string::npos) << imported.err;
  const auto shortened = gyrotherm_with("tell " + (folder_ / "two") + " note seen");
  EXPECT_NE(shortened.err.find("did you mean"), std::string::npos) << shortened.err;
}

TEST_F(CopyOfAnotherRun, EndsFollowing) {
  Background follower({"export", folder_ / "run.db", "--follow"}, folder_ / "followed");
  ASSERT_TRUE(follower.wait_for("\n39,", 60)) << follower.output();
  link_copy_to("two", 2);
  EXPECT_NE(follower.wait(), 0);
  EXPECT_EQ(follower.output().find("\n40,"), std::string::npos) << follower.output();
}

}  // namespace
}  // namespace gyrotherm::app
