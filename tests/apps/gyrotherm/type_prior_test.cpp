// SPDX-License-Identifier: Apache-2.0
/// The commands `type-prior` and `train --prior`.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"

namespace gyrotherm::app {
namespace {

/// Short records of four virtual gyros, and the prior of the first three.
class TypePriorCommand : public testing::Test {
 protected:
  static constexpr int kUnits = 4;
  static void SetUpTestSuite() {
    folder_ = new Folder;
    for (int seed = 1; seed <= kUnits; ++seed) {
      const auto recorded = gyrotherm_with(
          fmt::format("run tests/profiles/short-rate.toml --rig profiles/rigs/virtual.toml --seed {} --out {}", seed,
                      record(seed)));
      ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
    }
    learnt_ = gyrotherm_with(fmt::format("type-prior {} {} {} --quick --type ring --out {}", record(1), record(2),
                                         record(3), *folder_ / "prior.json"));
    ASSERT_EQ(learnt_.exit_code, 0) << learnt_.err;
    ready_ = true;
  }
  static void TearDownTestSuite() { delete folder_; }
  void SetUp() override { ASSERT_TRUE(ready_) << "the records or their prior are missing"; }

  static std::string record(int seed) { return *folder_ / fmt::format("r{}.db", seed); }
  static Ran train(const std::string& options) {
    return gyrotherm_with(fmt::format("train {} --prior {} --out {} {}", record(kUnits), *folder_ / "prior.json",
                                      *folder_ / "m.json", options));
  }

  static inline Folder* folder_ = nullptr;
  static inline Ran learnt_;
  static inline bool ready_ = false;
};

TEST_F(TypePriorCommand, DistinguishesVirtualGyrosBySeed) {
  for (const auto* words :
       {"SIMULATED: type \"ring\" of 3 units", "seed 1: 1 record, 4.", "A-B", "with a time constant of"})
    EXPECT_NE(learnt_.out.find(words), std::string::npos) << learnt_.out;
  const auto file = nlohmann::json::parse(read_text_file(*folder_ / "prior.json").value());
  EXPECT_EQ(file["schema"], "gyrotherm-type-prior/1");
  EXPECT_EQ(file["units"], (nlohmann::json{"seed 1", "seed 2", "seed 3"}));
  EXPECT_EQ(file["simulated"], true);
  EXPECT_EQ(file["terms"].size(), 8u);
}

TEST_F(TypePriorCommand, TrainsUsableModelFromOneHour) {
  const auto ran = train("--clusters 0:36");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  for (const auto* words : {"type-prior on A-B,", "type \"ring\" of 3 units (seed 1; seed 2; seed 3)",
                            "held out, 4 cons", "uncertainty of a mean over 1 h: U = "})
    EXPECT_NE(ran.out.find(words), std::string::npos) << ran.out;
  const auto verified =
      gyrotherm_with(fmt::format("verify {} {} --clusters 36:150 --json", *folder_ / "m.json", record(kUnits)));
  ASSERT_EQ(verified.exit_code, 0) << verified.err;
  const auto report = nlohmann::json::parse(verified.out);
  EXPECT_LT(report["compensated"]["std_deg_per_h"].get<double>(), 0.5 * report["raw"]["std_deg_per_h"].get<double>());
  EXPECT_GT(report["coverage"]["seen"], 0.8);
  const std::string model = *folder_ / "m.json";
  const auto exported = gyrotherm_with(fmt::format("export-model {} --as c --out {}", model, *folder_ / "m.c"));
  EXPECT_EQ(exported.exit_code, 0) << exported.err;
  const auto compensated =
      gyrotherm_with("compensate --uncertainty " + model, "A,B,C,D,E,F,G,H,bias\n20,20,20,20,20,20,20,20,0\n");
  EXPECT_EQ(compensated.exit_code, 0) << compensated.err;
}

TEST_F(TypePriorCommand, RefusesInconsistentRecordsAndReportsReusedGyro) {
  const auto refused = [&](const std::string& command, const std::string& why) {
    const auto ran = gyrotherm_with(command + " --out " + (*folder_ / "none.json"));
    EXPECT_EQ(ran.exit_code, 2) << command;
    EXPECT_NE(ran.err.find(why), std::string::npos) << ran.err;
    EXPECT_FALSE(std::filesystem::exists(*folder_ / "none.json"));
  };
  refused("type-prior", "records is required");
  refused("type-prior " + record(1) + " " + record(2), "2 units are too few");
  refused(fmt::format("type-prior {} {} {}", record(1), record(2), record(1)), "is the same run as");
  refused(fmt::format("type-prior a={} b={} a={}", record(1), record(2), record(3)), "2 units are too few");
  refused(fmt::format("type-prior {} {} {} --inputs multi-point", record(1), record(2), record(3)), "selects");
  refused(fmt::format("train {} --prior {} --method linear", record(4), *folder_ / "prior.json"), "--prior");
  refused("train --prior " + (*folder_ / "prior.json"), "runs is required");
  const auto ran = gyrotherm_with(
      fmt::format("train {} --prior tests/profiles/short-rate.toml --out {}", record(4), *folder_ / "none.json"));
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("short-rate.toml"), std::string::npos) << ran.err;
  const auto twice = gyrotherm_with(
      fmt::format("train {} --prior {} --out {}", record(2), *folder_ / "prior.json", *folder_ / "twice.json"));
  EXPECT_EQ(twice.exit_code, 0) << twice.err;
  EXPECT_NE(twice.out.find("the prior was also learnt from this gyro (seed 2)"), std::string::npos) << twice.out;
}

TEST_F(TypePriorCommand, IdentifiesGyroUnderAnyName) {
  const auto again = gyrotherm_with(
      fmt::format("run tests/profiles/short-random.toml --rig profiles/rigs/virtual.toml --seed 1 --out {}",
                  *folder_ / "again.db"));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const auto learnt = gyrotherm_with(fmt::format("type-prior a={} b={} c={} d={} --quick --out {}", record(1),
                                                 record(2), record(3), *folder_ / "again.db", *folder_ / "named.json"));
  ASSERT_EQ(learnt.exit_code, 0) << learnt.err;
  EXPECT_NE(learnt.err.find("the records of \"a\" and \"d\" name one gyro (seed 1), which is counted as two units"),
            std::string::npos)
      << learnt.err;
  const auto file = nlohmann::json::parse(read_text_file(*folder_ / "named.json").value());
  EXPECT_EQ(file["records"][3]["name"], "d");
  EXPECT_EQ(file["records"][3]["identity"], "seed 1");
  const auto model = gyrotherm_with(
      fmt::format("train {} --prior {} --out {}", record(2), *folder_ / "named.json", *folder_ / "twice2.json"));
  EXPECT_EQ(model.exit_code, 0) << model.err;
  EXPECT_NE(model.out.find("the prior was also learnt from this gyro (seed 2)"), std::string::npos) << model.out;
}

TEST(TypePriorOfForeignRecords, RequiresUnitOfEachRecord) {
  const Folder folder;
  make_small_model(folder);
  const std::string record = folder / "record.db";
  const auto ran = gyrotherm_with("type-prior " + record + " --out " + (folder / "none.json"));
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_NE(ran.err.find("UNIT=" + record), std::string::npos) << ran.err;
  const auto named = gyrotherm_with("type-prior u1=" + record + " --out " + (folder / "none.json"));
  EXPECT_NE(named.err.find("1 units are too few"), std::string::npos) << named.err;
}

}  // namespace
}  // namespace gyrotherm::app
