// SPDX-License-Identifier: Apache-2.0
/// Checks the commands, options and files that README.md and docs/tasks.md show.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <regex>
#include <sstream>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

const std::string kReadme = GYROTHERM_SOURCE_DIR "/README.md";
const std::string kTasks = GYROTHERM_SOURCE_DIR "/docs/tasks.md";

/// Returns the lines of a page's shell blocks.
std::vector<std::string> shown_commands(const std::string& page) {
  std::istringstream text(read_text_file(page).value());
  std::vector<std::string> commands;
  bool inside = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("```"))
      inside = line == "```sh";
    else if (inside)
      commands.push_back(line);
  }
  return commands;
}

TEST(Readme, ShowsTwoCommandsOfCi) {
  const auto commands = shown_commands(kReadme);
  ASSERT_GE(commands.size(), 2u);
  EXPECT_EQ(commands[0], "apt-get update && apt-get build-dep -y -P nocheck . && cmake --workflow --preset dry-run");
  EXPECT_NE(read_text_file(GYROTHERM_SOURCE_DIR "/.ci/run").value().find(commands[1] + "\n"), std::string::npos);
}

TEST(Readme, ShowsExistingCommandsAndOptions) {
  const std::regex command_name(R"(^gyrotherm ([a-z-]+))"), subcommand_name(R"(^gyrotherm ([a-z-]+ [a-z]+) )");
  int commands = 0, options = 0;
  auto lines = shown_commands(kReadme);
  std::ranges::copy(shown_commands(kTasks), std::back_inserter(lines));
  for (const auto& line : lines) {
    std::smatch match;
    if (!std::regex_search(line, match, command_name)) continue;
    const auto help = gyrotherm_with(match[1].str() + " --help");
    EXPECT_EQ(help.exit_code, 0) << line;
    auto known = options_in(help.out);
    if (std::smatch with_subcommand; std::regex_search(line, with_subcommand, subcommand_name))
      known.merge(options_in(gyrotherm_with(with_subcommand[1].str() + " --help").out));
    for (const auto& option : options_in(line)) {
      EXPECT_TRUE(known.contains(option)) << line << " " << option;
      ++options;
    }
    ++commands;
  }
  EXPECT_GE(commands, 40);
  EXPECT_GE(options, 45);
}

TEST(Readme, NamesExistingFiles) {
  const auto text = read_text_file(kReadme).value() + read_text_file(kTasks).value();
  const std::regex path(R"((profiles|docs|tests)/[A-Za-z0-9_/.-]*[a-z])");
  int files = 0;
  for (std::sregex_iterator named(text.begin(), text.end(), path), end; named != end; ++named, ++files)
    EXPECT_TRUE(std::filesystem::exists(GYROTHERM_SOURCE_DIR "/" + named->str())) << named->str();
  EXPECT_GE(files, 20);
}

}  // namespace
}  // namespace gyrotherm::app
