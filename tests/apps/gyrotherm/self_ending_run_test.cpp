// SPDX-License-Identifier: Apache-2.0
/// Runs that end by themselves, with the program and its real assessment of the uncertainty.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/decision.hpp"
#include "acquisition/record/record.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

const std::string kShort = "tests/profiles/short-until.toml --rig virtual-supply ";

std::vector<std::string> decision_texts(const record::Record& record) {
  std::vector<std::string> texts;
  for (const auto& [slot, event] : record.events)
    if (record::is_decision(event)) texts.push_back(event.text);
  return texts;
}

record::Decision last_decision(const record::Record& record) {
  const auto texts = decision_texts(record);
  return texts.empty() ? record::Decision{} : record::parse_decision(texts.back()).value();
}

class SelfEndingProgram : public ::testing::Test {
 protected:
  /// Runs to the end and returns the record.
  record::Record run(const std::string& name, const std::string& options) {
    const auto ran = gyrotherm_with("run " + kShort + options + " --out " + (folder_ / name));
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    return record::read_record(folder_ / name).value();
  }
  const Folder folder_;
};

TEST_F(SelfEndingProgram, TakesSamePathForSameSeed) {
  const auto first = run("a.db", "--seed 7"), second = run("b.db", "--seed 7");
  EXPECT_GE(decision_texts(first).size(), 2U);
  EXPECT_EQ(decision_texts(first), decision_texts(second));
  EXPECT_EQ(first.info.added_blocks, second.info.added_blocks);
  EXPECT_TRUE(record::has_ended(first.info));
  EXPECT_TRUE(record::verify_record(folder_ / "a.db"));
  EXPECT_EQ(first.info.goal->u_deg_per_h, 0.02);
  EXPECT_EQ(first.info.goal->mission_text,
            read_text_file(GYROTHERM_SOURCE_DIR "/tests/profiles/short-mission.toml").value_or(""));
}

TEST_F(SelfEndingProgram, EndsAtTargetOfCommandLine) {
  const auto easy = run("easy.db", "--until-u 1000");
  ASSERT_EQ(decision_texts(easy).size(), 1U) << "after the opening";
  EXPECT_EQ(last_decision(easy).end, "U is met");
  EXPECT_EQ(last_decision(easy).target_deg_per_h, 1000);
  EXPECT_EQ(easy.info.segments.size(), 4U) << "opening and closing";
  const auto hard = run("hard.db", "--until-u 1e-9");
  EXPECT_NE(last_decision(hard).end, "U is met");
  EXPECT_LE(hard.slot.back(), 3 * 3600) << "not longer than permitted";
}

TEST_F(SelfEndingProgram, StatusReportsUncertaintyAndTime) {
  (void)run("run.db", "--until-u 1000");
  const auto text = gyrotherm_with("status " + (folder_ / "run.db"));
  EXPECT_NE(text.out.find("1000 °/h wanted; the run ends: U is met"), std::string::npos) << text.out;
  const auto json = nlohmann::json::parse(gyrotherm_with("status --json " + (folder_ / "run.db")).out);
  EXPECT_EQ(json["decision"]["end"], "U is met");
  EXPECT_EQ(json["decision"]["blocks"].size(), 3U);
  EXPECT_EQ(json["segment_count"], 4);
}

TEST_F(SelfEndingProgram, RefusesGoalWithoutBlocksAndUpload) {
  const auto out = " --out " + (folder_ / "x.db");
  const auto without = gyrotherm_with("run random --rig virtual --until-u 0.01" + out);
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_NE(without.err.find("--until-u: the profile has no table [until]"), std::string::npos) << without.err;
  EXPECT_NE(without.err.find("[[until.block]]"), std::string::npos) << "says what to write";
  for (const auto* value : {"0", "-1", "inf", "nan", "x"}) {
    EXPECT_EQ(gyrotherm_with("run " + kShort + "--until-u " + value + out).exit_code, 2) << value;
  }
  EXPECT_EQ(gyrotherm_with("run " + kShort + "--upload" + out).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.db"));
}

TEST_F(SelfEndingProgram, RefusesMissionsThatCannotBeUsed) {
  const auto profile = read_text_file(GYROTHERM_SOURCE_DIR "/tests/profiles/short-until.toml").value();
  const auto with_mission = [&](const std::string& mission) {
    auto text = profile;
    text.replace(text.find("short-mission.toml"), std::string("short-mission.toml").size(), mission);
    std::ofstream(folder_ / "p.toml") << text;
    return gyrotherm_with("run " + (folder_ / "p.toml") + " --rig virtual-supply --out " + (folder_ / "x.db"));
  };
  EXPECT_EQ(with_mission("./missing.toml").exit_code, 4);
  EXPECT_EQ(with_mission("no-such-profile").exit_code, 4);
  EXPECT_EQ(with_mission("p.toml").exit_code, 4) << "a mission has a fixed end";
  std::ofstream(folder_ / "broken.toml") << "schema = \"gyrotherm-profile/1\"\n";
  EXPECT_EQ(with_mission("broken.toml").exit_code, 4);
  EXPECT_EQ(with_mission("shipboard").exit_code, 0) << "a shipped profile";
}

TEST_F(SelfEndingProgram, CheckPrintsBlocks) {
  const auto checked = gyrotherm_with("check until --rig virtual-supply");
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  for (const auto* part : {"until U = 0.012 °/h on shipboard, at most 40:00:00",
                           "block \"cold, fast\", 1:00:00:", "block \"power-on at 20 °C\"", "closing, 0:50:00:"})
    EXPECT_NE(checked.out.find(part), std::string::npos) << part << "\n" << checked.out;
}

/// Kills the program at moments all over the run. The resumed run takes the path of a run that was never killed.
TEST_F(SelfEndingProgram, TakesSamePathWhenKilledAndResumed) {
  const auto arguments = [&](const std::string& name) {
    return std::vector<std::string>{
        "run",         "tests/profiles/short-until.toml", "--rig", "virtual-supply", "--until-u", "1e-9", "--out",
        folder_ / name};
  };
  std::chrono::nanoseconds whole{};
  {
    Background twin(arguments("twin.db"), folder_ / "twin.log");
    for (; twin.is_running(); std::this_thread::sleep_for(std::chrono::milliseconds(1)))
      whole = std::max(whole, twin.processor_time());
    ASSERT_EQ(twin.wait(), 0) << twin.output();
  }
  const auto path = record::read_record(folder_ / "twin.db").value().info.added_blocks;
  ASSERT_GE(path.size(), 3U);
  int killed = 0;
  constexpr int kMoments = 8;
  for (int i = 1; i <= kMoments; ++i) {
    const auto name = "run" + std::to_string(i) + ".db";
    {
      Background run(arguments(name), folder_ / (name + ".log"));
      while (run.is_running() && run.processor_time() < whole * i / (kMoments + 1))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      run.signal(SIGKILL);
      if (run.wait() != -SIGKILL) continue;
    }
    const auto before = record::read_record(folder_ / name);
    if (!before || before->finished) continue;
    ++killed;
    const auto resumed = gyrotherm_with("resume --gap 1s " + (folder_ / name));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    const auto record = record::read_record(folder_ / name).value();
    EXPECT_EQ(record.info.added_blocks, path) << "killed at second " << before->slot.size();
    EXPECT_TRUE(record::verify_record(folder_ / name));
  }
  EXPECT_GE(killed, kMoments / 2);
}

}  // namespace
}  // namespace gyrotherm::app
