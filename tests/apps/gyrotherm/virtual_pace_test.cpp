// SPDX-License-Identifier: Apache-2.0
/// Virtual runs that a person watches: their pace, and a pause that waits for the person.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>

#include "acquisition/record/record.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono::steady_clock;

/// Waits at most ten seconds until the condition holds.
template <class Condition>
bool becomes(Condition condition) {
  for (int i = 0; i < 100; ++i) {
    if (condition()) return true;
    shell("sleep 0.1");
  }
  return condition();
}

TEST(VirtualPace, IsThatOfOption) {
  const Folder folder;
  const auto began = steady_clock::now();
  const auto ran =
      gyrotherm_with("run tests/profiles/ten-seconds.toml --rig virtual --pace x5 --out " + (folder / "run.db"));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_GE(steady_clock::now() - began, std::chrono::milliseconds(1800));
}

TEST(VirtualPace, DoesNotChangeRecord) {
  const Folder folder;
  for (const auto* pace : {"max", "x10"})
    ASSERT_EQ(gyrotherm_with(std::string("run tests/profiles/ten-seconds.toml --rig virtual --pace ") + pace +
                             " --out " + (folder / (std::string(pace) + ".db")))
                  .exit_code,
              0);
  const auto rows = [&](const char* name) {
    return shell("gyrotherm export --quiet " + (folder / name) + " --out " + (folder / "t.csv") +
                 " --force && grep -v '^#' " + (folder / "t.csv"))
        .out;
  };
  const auto fast = rows("max.db");
  EXPECT_GT(fast.size(), 500U);
  EXPECT_EQ(fast, rows("x10.db"));
}

TEST(VirtualPace, ContinuesInNewPartIfRecordIsMoved) {
  const Folder folder;
  const auto record = folder / "run.db";
  Background run({"run", "profiles/qualification.toml", "--rig", "virtual", "--pace", "x60", "--json", "--out", record},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\"", 60)) << run.output();
  std::filesystem::rename(record, folder / "moved.db");
  EXPECT_TRUE(becomes([&] { return std::filesystem::exists(folder / "run.2.db"); })) << run.output();
  run.signal(SIGINT);
  EXPECT_EQ(run.wait(), 5) << run.output();
  EXPECT_EQ(run.output().find("NOT confirmed safe"), std::string::npos) << run.output();
}

TEST(VirtualPace, IsRefusedForRealRigAndUnknownValue) {
  const Folder folder;
  const auto run = [&](const std::string& rest) {
    return gyrotherm_with("run tests/profiles/ten-seconds.toml --out " + (folder / "run.db") + " " + rest);
  };
  const auto real = run("--rig example-f4t-lakeshore-kvh --unit 0042 --pace x10");
  EXPECT_EQ(real.exit_code, 2);
  EXPECT_NE(real.err.find("--pace: only valid on a virtual rig"), std::string::npos) << real.err;
  const auto fast = run("--rig virtual --pace fast");
  EXPECT_EQ(fast.exit_code, 2);
  EXPECT_NE(fast.err.find("\"fast\", expected real, max or xN"), std::string::npos) << fast.err;
}

/// Without a pace, a virtual run used to reach `longest_held` within seconds of a pause.
TEST(VirtualPace, PauseWaitsForOperatorAtAnyPace) {
  for (const auto* pace : {"max", "x500"}) {
    const Folder folder;
    const auto record = folder / "run.db";
    Background run(
        {"run", "profiles/qualification.toml", "--rig", "virtual", "--pace", pace, "--json", "--out", record},
        folder / "log");
    ASSERT_TRUE(run.wait_for("\"acknowledged\"", 60)) << run.output();
    const auto tell = [&](const std::string& words) { return gyrotherm_with("tell " + record + " " + words); };
    ASSERT_EQ(tell("pause").exit_code, 0) << run.output();
    const auto state = [&] { return shell("gyrotherm status --json " + record).out; };
    ASSERT_TRUE(becomes([&] { return state().find("\"state\":\"held\"") != std::string::npos; }));
    shell("sleep 3");
    EXPECT_NE(state().find("\"state\":\"held\""), std::string::npos) << pace << state();
    ASSERT_EQ(tell("note looked").exit_code, 0);
    ASSERT_EQ(tell("resume").exit_code, 0);
    ASSERT_TRUE(becomes([&] { return state().find("\"state\":\"held\"") == std::string::npos; }));
    run.signal(SIGINT);
    EXPECT_EQ(run.wait(), 5) << run.output();
    const auto kept = record::read_record(record);
    ASSERT_TRUE(kept) << text(kept.error());
    Duration held{};
    for (const auto& stored : kept->events) {
      if (stored.event.text.find("pause") != std::string::npos) held -= stored.event.at.since_start;
      if (stored.event.text.find("resume") != std::string::npos) held += stored.event.at.since_start;
      if (held > Duration{}) break;
    }
    EXPECT_LT(held, std::chrono::minutes(2)) << pace;
  }
}

}  // namespace
}  // namespace gyrotherm::app
