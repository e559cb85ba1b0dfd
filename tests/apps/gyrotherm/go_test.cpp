// SPDX-License-Identifier: Apache-2.0
/// Manual set point: a run like any other.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "acquisition/record/record.hpp"
#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

constexpr auto* kVirtual = "profiles/rigs/virtual.toml";

TEST(Go, MovesChamberAndRecordsIt) {
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

TEST(Go, RespectsLimitsOfRig) {
  const Folder folder;
  for (const auto* beyond : {"95", "-60", "nan", "inf"}) {
    const auto record = folder / "never.db";
    const auto ran = gyrotherm_with("go " + std::string(kVirtual) + " " + beyond + " --out " + record);
    EXPECT_EQ(ran.exit_code, 2) << beyond << ran.err;
    EXPECT_EQ(ran.err.find("go:"), std::string::npos) << "a position in a file that does not exist: " << ran.err;
    EXPECT_FALSE(std::filesystem::exists(record)) << beyond;
  }
  EXPECT_EQ(gyrotherm_with("go " + std::string(kVirtual) + " warm").exit_code, 2);
  const auto swapped = gyrotherm_with("go 25 " + std::string(kVirtual));
  EXPECT_EQ(swapped.exit_code, 2);
  EXPECT_NE(swapped.err.find("rig: \"25\" is a set point, expected the rig before it"), std::string::npos)
      << swapped.err;
  const auto never = gyrotherm_with("go " + std::string(kVirtual) + " 25 --for soon");
  EXPECT_EQ(never.exit_code, 2);
  EXPECT_NE(never.err.find("--for"), std::string::npos) << never.err;
}

/// A controller does not know the rig's fastest rates, so it must not approach the profile's first set point itself.
TEST(Go, IsRequiredBeforeUploadWithOtherStart) {
  const Folder folder;
  auto rig = read_text_file(std::string(GYROTHERM_SOURCE_DIR "/") + kVirtual).value();
  rig = std::regex_replace(rig, std::regex("\\.\\./chambers/virtual"), "../chambers/watlow_f4t");
  rig = std::regex_replace(rig, std::regex("\"\\.\\./"), "\"" GYROTHERM_SOURCE_DIR "/profiles/");
  std::ofstream(folder / "f4t.toml") << rig;
  const auto upload = [&](const std::string& at) {
    const auto profile = folder / (at + ".toml");
    std::ofstream(profile) << "schema = \"gyrotherm-profile/1\"\nname = \"p\"\n"
                           << "[[segment]]\nkind = \"hold\"\ntime = \"2 s\"\nat = " << at << "\n";
    return gyrotherm_with("run " + profile + " --upload --rig " + (folder / "f4t.toml") + " --out " + (folder / at));
  };
  const auto refused = upload("60");
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_NE(refused.err.find("ramp there first with \"gyrotherm go\""), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "60"));
  const auto carried_out = upload("20");
  EXPECT_EQ(carried_out.exit_code, 0) << carried_out.err;
}

TEST(Go, NamesRecordAfterTime) {
  const Folder folder;
  const auto ran =
      shell("rig=$PWD/" + std::string(kVirtual) + "; cd " + (folder / "") +
            " && gyrotherm go $rig 21 --for '2 s' --quiet && gyrotherm go $rig 21 --for '2 s' --out again.db"
            " && ls go-*-*-*-*.db again.db");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
}

}  // namespace
}  // namespace gyrotherm::app
