// SPDX-License-Identifier: Apache-2.0
/// The set point by hand: a run like any other.
#include <gtest/gtest.h>

#include <filesystem>

#include "acquisition/record/record.hpp"
#include "tests/app/program.hpp"

namespace gyrotherm::app {
namespace {

constexpr auto* kVirtual = "profiles/rigs/virtual.toml";

TEST(Go, BringsTheChamberThereAndKeepsARecordOfIt) {
  const Folder folder;
  const auto record = folder / "cold.db";
  const auto ran = gyrotherm_with("go " + std::string(kVirtual) + " -12.5 --for '90 min' --quiet --out " + record);
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto kept = record::read_record(record);
  ASSERT_TRUE(kept) << text(kept.error());
  EXPECT_EQ(kept->info.profile_name, "go to -12.5 °C");
  EXPECT_EQ(kept->set_point_c.back(), -12.5);
  EXPECT_NEAR(kept->chamber_air_c.back(), -12.5, 1);
}

TEST(Go, GoesThroughTheLimitsOfTheRig) {
  const Folder folder;
  for (const auto* beyond : {"95", "-60", "nan", "inf"}) {
    const auto record = folder / "never.db";
    const auto ran = gyrotherm_with("go " + std::string(kVirtual) + " " + beyond + " --out " + record);
    EXPECT_EQ(ran.exit_code, 2) << beyond << ran.err;
    EXPECT_EQ(ran.err.find("go:"), std::string::npos) << "a place in a file that nobody wrote: " << ran.err;
    EXPECT_FALSE(std::filesystem::exists(record)) << beyond;
  }
  EXPECT_EQ(gyrotherm_with("go " + std::string(kVirtual) + " warm").exit_code, 2);
  const auto never = gyrotherm_with("go " + std::string(kVirtual) + " 25 --for soon");
  EXPECT_EQ(never.exit_code, 2);
  EXPECT_NE(never.err.find("--for"), std::string::npos) << never.err;
}

TEST(Go, NamesItsRecordByTheTime) {
  const Folder folder;
  const auto ran =
      shell("rig=$PWD/" + std::string(kVirtual) + "; cd " + (folder / "") +
            " && gyrotherm go $rig 21 --for '2 s' --quiet && gyrotherm go $rig 21 --for '2 s' --out again.db"
            " && ls go-*-*-*-*.db again.db");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
}

}  // namespace
}  // namespace gyrotherm::app
