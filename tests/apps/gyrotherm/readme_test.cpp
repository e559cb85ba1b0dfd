// SPDX-License-Identifier: Apache-2.0
/// What the README shows is there: its commands, their options, its files.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <sstream>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// The lines of the README's shell blocks.
std::vector<std::string> shown_commands() {
  std::istringstream readme(read_text_file(GYROTHERM_SOURCE_DIR "/README.md").value());
  std::vector<std::string> commands;
  bool inside = false;
  for (std::string line; std::getline(readme, line);) {
    if (line.starts_with("```"))
      inside = line == "```sh";
    else if (inside)
      commands.push_back(line);
  }
  return commands;
}

TEST(Readme, ItsTwoCommandsAreWhatCiRuns) {
  const auto commands = shown_commands();
  ASSERT_GE(commands.size(), 2u);
  EXPECT_EQ(commands[0], "apt-get update && apt-get build-dep -y -P nocheck . && cmake --workflow --preset dry-run");
  EXPECT_NE(read_text_file(GYROTHERM_SOURCE_DIR "/.ci/run").value().find(commands[1] + "\n"), std::string::npos);
}

TEST(Readme, EveryCommandExistsWithEveryOptionShown) {
  const std::regex command_name(R"(^gyrotherm ([a-z-]+))");
  int commands = 0, options = 0;
  for (const auto& line : shown_commands()) {
    std::smatch match;
    if (!std::regex_search(line, match, command_name)) continue;
    const auto help = gyrotherm_with(match[1].str() + " --help");
    EXPECT_EQ(help.exit_code, 0) << line;
    const auto known = options_in(help.out);
    for (const auto& option : options_in(line)) {
      EXPECT_TRUE(known.contains(option)) << line << " " << option;
      ++options;
    }
    ++commands;
  }
  EXPECT_GE(commands, 20);
  EXPECT_GE(options, 35);
}

TEST(Readme, EveryFileItNamesIsThere) {
  const auto readme = read_text_file(GYROTHERM_SOURCE_DIR "/README.md").value();
  const std::regex path(R"((profiles|docs|tests)/[A-Za-z0-9_/.-]*[a-z])");
  int files = 0;
  for (std::sregex_iterator named(readme.begin(), readme.end(), path), end; named != end; ++named, ++files)
    EXPECT_TRUE(std::filesystem::exists(GYROTHERM_SOURCE_DIR "/" + named->str())) << named->str();
  EXPECT_GE(files, 20);
}

}  // namespace
}  // namespace gyrotherm::app
