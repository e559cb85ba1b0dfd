// SPDX-License-Identifier: Apache-2.0
/// Effects of Ctrl-C, SIGTERM, a lost terminal and a closed reader.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "tests/apps/gyrotherm/listener.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;
using std::chrono::steady_clock;

/// Returns the exit code, or −signal. Fails the test if the program never ends. The code shows whether the signal or
/// the end of the work ended the program.
int wait_for_end(Background& program) {
  const auto began = steady_clock::now();
  while (program.is_running() && steady_clock::now() - began < 60s) std::this_thread::sleep_for(5ms);
  EXPECT_FALSE(program.is_running()) << "still there";
  if (program.is_running()) program.signal(SIGKILL);
  return program.wait();
}

/// Writes a table that takes seconds to import.
void write_long_table(const std::string& path) {
  std::ofstream table(path);
  for (int row = 0; row < 6'000'000; ++row) table << row << ",20.125,20.25,1.5e-3,7\n";
}

constexpr const char* kMap = R"(schema = "gyrotherm-import/1"
name = "long"
[file]
header = false
[time]
column = 1
unit = "s"
[[thermometer]]
name = "A"
column = 2
[gyro]
column = 4
kind = "rate"
scale = 1.0
)";

TEST(Interrupt, EndsSimpleCommandImmediately) {
  const Folder folder;
  const Listener chamber;
  ASSERT_EQ(shell("sed 's#tcp://[0-9.]*:502#tcp://127.0.0.1:" + std::to_string(chamber.port()) +
                  "#' profiles/rigs/example-f4t-lakeshore-kvh.toml > '" + (folder / "rig.toml") + "'")
                .exit_code,
            0);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    Background check({"check", "--rig", folder / "rig.toml", "--connect"}, folder / "out");
    std::this_thread::sleep_for(300ms);
    ASSERT_TRUE(check.is_running()) << check.output();
    check.signal(number);
    EXPECT_EQ(wait_for_end(check), -number);
  }
}

TEST(Interrupt, LeavesNoFileOfImport) {
  const Folder folder;
  write_long_table(folder / "long.csv");
  std::ofstream(folder / "map.toml") << kMap;
  std::filesystem::create_directory(folder / "records");
  const auto record = folder / "records/r.db";
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    Background import({"import", folder / "long.csv", "--map", folder / "map.toml", "--out", record}, folder / "out");
    while (import.is_running() && !std::filesystem::exists(record)) std::this_thread::sleep_for(5ms);
    ASSERT_TRUE(import.is_running()) << import.output();
    import.signal(number);
    EXPECT_EQ(wait_for_end(import), 5) << import.output();
    EXPECT_TRUE(std::filesystem::is_empty(folder / "records")) << "after signal " << number;
  }
}

TEST(Interrupt, StopsServerInOrder) {
  const Folder folder;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    Background simulate({"simulate"}, folder / ("out" + std::to_string(number)));
    ASSERT_TRUE(simulate.wait_for("gyro ", 60)) << simulate.output();
    simulate.signal(number);
    EXPECT_EQ(wait_for_end(simulate), 0);
  }
}

/// The mesh is solved in one step that does not check for a stop.
TEST(Interrupt, EndsBusyCommandWhenRepeated) {
  const Folder folder;
  Background thermal({"thermal", "--verbose", "--mesh", "fine", "--out", folder / "image"}, folder / "out");
  ASSERT_TRUE(thermal.wait_for("steady state", 60)) << thermal.output();
  thermal.signal(SIGINT);
  thermal.signal(SIGINT);
  std::this_thread::sleep_for(700ms);
  if (!thermal.is_running()) GTEST_SKIP() << "this machine solves it too fast";
  thermal.signal(SIGINT);
  EXPECT_EQ(wait_for_end(thermal), -SIGINT) << "two simultaneous signals count as one; the next one counts";
}

TEST(Interrupt, StopsThermalWithoutImage) {
  const Folder folder;
  Background thermal({"thermal", "--verbose", "--mesh", "coarse", "--out", folder / "image"}, folder / "out");
  ASSERT_TRUE(thermal.wait_for("steady state", 60)) << thermal.output();
  thermal.signal(SIGINT);
  EXPECT_EQ(wait_for_end(thermal), 5) << thermal.output();
  EXPECT_TRUE(std::filesystem::is_empty(folder / "image"));
}

TEST(Interrupt, KeepsHangUpIgnoredUnderNohup) {
  const Folder folder;
  const std::string out = folder / "out";
  const auto ran =
      shell("nohup " GYROTHERM_PROGRAM " simulate > " + out + " 2>&1 & pid=$!; until grep -q 'gyro ' " + out +
            "; do kill -0 $pid || break; sleep 0.05; done; kill -HUP $pid; sleep 0.5; "
            "kill -0 $pid && echo alive; kill -TERM $pid; wait $pid; echo $?");
  EXPECT_EQ(ran.out, "alive\n0\n") << ran.err;
}

TEST(Interrupt, AcceptsClosedReader) {
  const auto ran = shell("{ sleep 0.3; gyrotherm check profiles/qualification.toml; echo $? >&2; } | true");
  EXPECT_EQ(ran.err, "0\n");
  const auto full = shell("gyrotherm check profiles/qualification.toml > /dev/full");
  EXPECT_EQ(full.exit_code, 4);
  EXPECT_EQ(full.err, "gyrotherm: stdout: cannot be written\n");
}

TEST(Interrupt, ReportsFileSizeLimitAsFault) {
  const Folder folder;
  const auto bounded = [&](const std::string& command) {
    return shell("( ulimit -f 1500; gyrotherm " + command + " )");  // blocks of 512 bytes
  };
  const auto ran = bounded("run tests/profiles/short-rate.toml --rig virtual --quiet --out " + (folder / "bounded.db"));
  EXPECT_EQ(ran.exit_code, 4) << ran.err;
  EXPECT_NE(ran.err.find("the chamber was sent to"), std::string::npos) << ran.err;
  const auto whole = shell("gyrotherm run tests/profiles/short-rate.toml --rig virtual --out " + (folder / "whole.db"));
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const auto table = bounded("export " + (folder / "whole.db") + " --out " + (folder / "whole.csv"));
  EXPECT_EQ(table.exit_code, 4);
  EXPECT_EQ(table.err, "gyrotherm: " + (folder / "whole.csv") + ": cannot be written: File too large\n");
  EXPECT_EQ(shell("ls '" + (folder / "") + "' | grep -c part").out, "0\n");
}

TEST(Interrupt, SurvivesUnwritableMessages) {
  const auto wrong = shell("gyrotherm check --conect 2> /dev/full");
  EXPECT_EQ(wrong.exit_code, 2);
  const auto none = shell("gyrotherm status nowhere.db 2> /dev/full");
  EXPECT_EQ(none.exit_code, 4);
}

TEST(DefaultRecord, IsPlainNameInWorkingFolder) {
  const Folder folder;
  std::filesystem::create_directories(folder / "in/here");
  const std::string profile = R"(schema = "gyrotherm-profile/1"
name = "{}"
[[segment]]
kind = "hold"
at = 20
time = "2 s"
)";
  const std::vector<std::pair<std::string, std::string>> names{
      {"../evil", "_._evil.db"}, {"/tmp/evil", "_tmp_evil.db"}, {".hidden", "_hidden.db"},
      {"-rf", "_rf.db"},         {"\\u001b[2J", "_[2J.db"},     {"20 °C, slow", "20 °C, slow.db"}};
  for (const auto& [name, record] : names) {
    auto text = profile;
    std::ofstream(folder / "in/p.toml") << text.replace(text.find("{}"), 2, name);
    const auto ran = shell("rig=$PWD/profiles/rigs/virtual.toml; cd '" + (folder / "in/here") +
                           "' && gyrotherm run ../p.toml --rig $rig --quiet");
    EXPECT_EQ(ran.exit_code, 0) << name << ": " << ran.err;
    EXPECT_TRUE(std::filesystem::exists(folder / ("in/here/" + record))) << name;
    std::filesystem::remove_all(folder / "in/here");
    std::filesystem::create_directory(folder / "in/here");
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "in/evil.db"));
}

}  // namespace
}  // namespace gyrotherm::app
