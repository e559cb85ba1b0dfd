// SPDX-License-Identifier: Apache-2.0
/// A thermometer of a real rig whose driver is a program of somebody else: checked, run, and lost for a while.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "acquisition/record/record.hpp"
#include "core/file.hpp"
#include "tests/app/real_rig.hpp"

namespace gyrotherm::app {
namespace {

/// Dies once a file "die" is there, and leaves its number in "pids" each time that it starts.
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
    std::ofstream(folder / "acme.sh") << kProgram;
    std::filesystem::permissions(folder / "acme.sh", std::filesystem::perms::owner_all);
    auto text = read_text_file(laboratory.rig()).value();
    const auto channels = text.find(R"(channels = ["shell"])");
    ASSERT_NE(channels, std::string::npos);
    const auto begin = text.rfind("[[thermometer]]", channels);
    text.replace(begin, channels - begin, "[[thermometer]]\ndriver = \"process\"\ncommand = [\"./acme.sh\"]\n");
    std::ofstream(rig) << text;
  }
  /// Numbers of all processes that the program ever was.
  [[nodiscard]] std::set<pid_t> pids() const {
    std::set<pid_t> all;
    std::ifstream file(folder / "pids");
    for (pid_t one = 0; file >> one;) all.insert(one);
    return all;
  }

  const Folder folder;
  const RealLaboratory laboratory{folder / ""};
  const std::string rig = folder / "program.toml", record = folder / "run.db";
};

TEST_F(ProgramOfOthers, IsNamedByCheckAndRunByItOnlyToConnect) {
  const auto checked = gyrotherm_with("check --rig " + rig);
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_NE(checked.out.find("shell: by the program ./acme.sh"), std::string::npos) << checked.out;
  const auto looked = gyrotherm_with("doctor --rig " + rig);
  EXPECT_NE(looked.out.find("acme.sh may be run"), std::string::npos) << looked.out << looked.err;
  EXPECT_TRUE(pids().empty()) << "neither has run it";
  const auto connected = gyrotherm_with("check --connect --rig " + rig);
  EXPECT_EQ(connected.exit_code, 0) << connected.err;
  EXPECT_NE(connected.out.find("Acme T-1 0815"), std::string::npos) << connected.out;
  EXPECT_FALSE(pids().empty());
  for (const auto pid : pids()) EXPECT_NE(::kill(pid, 0), 0) << "it is left";
}

TEST_F(ProgramOfOthers, WhereItMayNotBeRunDoctorSaysSo) {
  std::filesystem::permissions(folder / "acme.sh", std::filesystem::perms::owner_read);
  const auto looked = gyrotherm_with("doctor --rig " + rig);
  EXPECT_EQ(looked.exit_code, 3) << looked.out;
  EXPECT_NE(looked.out.find("is no program that this user may run"), std::string::npos) << looked.out;
}

TEST_F(ProgramOfOthers, ItsDeathIsAFaultOfItsChannelAndTheRunGoesOn) {
  Background run({"run", "tests/profiles/ten-minutes-warm.toml", "--rig", rig, "--out", record, "--json"},
                 folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 2}", 60)) << run.output();
  std::ofstream(folder / "die") << "now\n";
  const auto reached = last_acknowledged(run.output()) + 6;
  EXPECT_TRUE(run.wait_for("\"acknowledged\": " + std::to_string(reached) + "}", 60)) << run.output();
  run.signal(SIGTERM);
  EXPECT_EQ(run.wait(), 5) << run.output();
  EXPECT_GE(pids().size(), 2u) << "it was started anew";
  for (const auto pid : pids()) EXPECT_NE(::kill(pid, 0), 0) << "it is left";
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  std::string events;
  for (const auto& stored : kept->events) events += stored.event.text + "\n";
  for (const auto* part : {"the program ended with exit code 3; it said \"the port is gone\""})
    EXPECT_NE(events.find(part), std::string::npos) << part << " in\n" << events;
  EXPECT_EQ(kept->thermometers_c.back().back(), 20.5) << "and reads again";
  EXPECT_GE(kept->slot.size(), static_cast<std::size_t>(reached));
}

}  // namespace
}  // namespace gyrotherm::app
