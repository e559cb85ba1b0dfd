/// A run on a real rig: it is guarded, the chamber is its own, and other programs may speak to it.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>

#include "core/text_file.hpp"
#include "tests/app/real_laboratory.hpp"

namespace gyrotherm {
namespace {

constexpr double kSafe = 20;    ///< °C, of the rig
constexpr double kWarm = 21.5;  ///< of the profile
constexpr double kLimit = 20;   ///< s, within which the chamber is safe

std::vector<std::string> warm_run(const RealLaboratory& laboratory, const std::string& record) {
  return {"run", "tests/profiles/ten-minutes-warm.toml", "--rig", laboratory.rig(), "--out", record, "--json"};
}

TEST(GuardedRun, AKilledProgramLeavesTheChamberSafeWithinTwentySeconds) {
  if (!installed("mbpoll")) GTEST_SKIP() << "mbpoll is not installed";
  const Folder folder;
  const RealLaboratory laboratory(folder);
  ASSERT_TRUE(laboratory.serves());
  const auto record = folder / "run.db";
  Background run(warm_run(laboratory, record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  ASSERT_TRUE(laboratory.wait_for_set_point(kWarm, 5));
  EXPECT_TRUE(std::filesystem::exists(record + ".armed"));
  run.signal(SIGKILL);
  EXPECT_TRUE(laboratory.wait_for_set_point(kSafe, kLimit)) << run.output();
  EXPECT_EQ(run.wait(), -SIGKILL);
  for (int i = 0; i < 50 && std::filesystem::exists(record + ".armed"); ++i) shell("sleep 0.1");
  EXPECT_FALSE(std::filesystem::exists(record + ".armed")) << "the chamber has confirmed it";
  const auto status = gyrotherm_with("status " + record);
  EXPECT_NE(status.out.find("made safe by the guard at "), std::string::npos) << status.out << status.err;
}

TEST(GuardedRun, AnOrderlyStopLeavesTheSetPointAndNobodyOnGuard) {
  if (!installed("mbpoll")) GTEST_SKIP() << "mbpoll is not installed";
  const Folder folder;
  const RealLaboratory laboratory(folder);
  ASSERT_TRUE(laboratory.serves());
  const auto record = folder / "run.db";
  Background run(warm_run(laboratory, record), folder / "log");
  ASSERT_TRUE(run.wait_for("\"acknowledged\": 1}", 60)) << run.output();
  Background second(warm_run(laboratory, folder / "second.db"), folder / "second.log");
  EXPECT_EQ(second.wait(), 3) << "one program drives a chamber";
  EXPECT_NE(second.output().find("another program drives it: process "), std::string::npos) << second.output();
  EXPECT_FALSE(std::filesystem::exists(folder / "second.db"));
  run.signal(SIGTERM);
  EXPECT_EQ(run.wait(), 5) << run.output();
  EXPECT_FALSE(std::filesystem::exists(record + ".armed"));
  EXPECT_EQ(shell("sleep 2").exit_code, 0);
  EXPECT_EQ(laboratory.set_point(), kWarm);
  EXPECT_FALSE(std::filesystem::exists(record + ".made-safe"));
}

}  // namespace
}  // namespace gyrotherm
