// SPDX-License-Identifier: Apache-2.0
/// Shipped files are found by name from any folder, other files by their path.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// Runs a command line in another folder.
Ran from(const std::string& folder, const std::string& command) { return shell("cd '" + folder + "' && " + command); }

TEST(Shipped, FindsProfilesAndRigsByNameFromAnyFolder) {
  const Folder folder;
  const auto ran = from(folder / "", "gyrotherm check qualification --rig virtual");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("2216"), std::string::npos);
}

TEST(Shipped, HelpExamplesWorkFromAnyFolder) {
  const Folder folder;
  for (const auto* command : {"check", "doctor", "completion"}) {
    const auto ran = from(folder / "", "gyrotherm " + std::string(command) +
                                           " --help | sed -n '1s/^Example: //p' > line && test -s line && . ./line");
    EXPECT_TRUE(ran.exit_code == 0 || (ran.exit_code == 4 && command == std::string("doctor"))) << command << ran.err;
  }
}

TEST(Shipped, PrefersShippedNameToFileInWorkingFolder) {
  const Folder folder;
  std::ofstream(folder / "qualification") << "this is not a profile";
  std::ofstream(folder / "qualification.toml") << "neither = \"is this\"";
  EXPECT_EQ(from(folder / "", "gyrotherm check qualification").exit_code, 0);
  for (const auto* path : {"./qualification", "qualification.toml"})
    EXPECT_EQ(from(folder / "", std::string("gyrotherm check ") + path).exit_code, 4) << path;
}

TEST(Shipped, ListsNamesAndFoldersWhenNameIsUnknown) {
  const Folder folder;
  std::ofstream(folder / "qualifcation") << "";
  const auto ran = from(folder / "", "gyrotherm check qualifcation");
  EXPECT_EQ(ran.exit_code, 4);
  for (const auto* word : {"\"qualifcation\": is not a shipped profile", "did you mean \"qualification\"?",
                           "write ./qualifcation", "cold-start, ", "/share/gyrotherm/profiles, ",
                           "/usr/local/share/gyrotherm/profiles", "/usr/share/gyrotherm/profiles"})
    EXPECT_NE(ran.err.find(word), std::string::npos) << word << " in " << ran.err;
  for (const auto* command : {"run random --rig virtul", "simulate --rig virtul", "qualify --rig virtul --out x"}) {
    const auto rig = from(folder / "", std::string("gyrotherm ") + command);
    EXPECT_EQ(rig.exit_code, 4) << command;
    EXPECT_NE(rig.err.find("did you mean \"virtual\"?"), std::string::npos) << rig.err;
  }
}

TEST(Shipped, ResolvesShippedMapsForRigFileElsewhere) {
  const Folder folder;
  const auto ran = shell("cp profiles/rigs/example-f4t-lakeshore-kvh.toml '" + (folder / "mine.toml") + "' && cd '" +
                         (folder / "") + "' && gyrotherm check --rig mine.toml");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  const auto misspelt = from(folder / "",
                             "sed -i 's/\"watlow_f4t\"/\"watlow_f5t\"/' mine.toml && gyrotherm check --rig "
                             "mine.toml");
  EXPECT_EQ(misspelt.exit_code, 4);
  EXPECT_NE(misspelt.err.find("mine.toml:9:7"), std::string::npos) << misspelt.err;
  EXPECT_NE(misspelt.err.find("did you mean \"watlow_f4t\"?"), std::string::npos) << misspelt.err;
}

TEST(Shipped, FindsColumnMapByName) {
  const Folder folder;
  const auto ran = from(folder / "", "gyrotherm import nowhere.csv --map freeimu --out x.db");
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.err.find("nowhere.csv"), std::string::npos) << ran.err;
}

}  // namespace
}  // namespace gyrotherm::app
