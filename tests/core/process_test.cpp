// SPDX-License-Identifier: Apache-2.0
#include "core/process.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace gyrotherm {
namespace {

namespace fs = std::filesystem;

TEST(ProgramInPath, IsFirstExecutableFile) {
  const fs::path folder = fs::temp_directory_path() / ("gyrotherm-path-" + std::to_string(::getpid()));
  fs::create_directories(folder / "a/tool");  // a folder, not a program
  fs::create_directories(folder / "b");
  fs::create_directories(folder / "c");
  for (const char* file : {"b/tool", "c/tool"}) std::ofstream(folder / file) << "#!/bin/sh\n";
  fs::permissions(folder / "c/tool", fs::perms::owner_all);
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", (folder.string() + "/a:" + folder.string() + "/b:c").c_str(), 1);
  EXPECT_EQ(find_program_in_path("tool", folder), folder / "c/tool");
  EXPECT_EQ(find_program_in_path("tool"), "");
  ::unsetenv("PATH");
  EXPECT_EQ(find_program_in_path("sh"), "/usr/bin/sh");
  ::setenv("PATH", before.c_str(), 1);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace gyrotherm
