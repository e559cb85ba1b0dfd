// SPDX-License-Identifier: Apache-2.0
/// Manual pages: one for each command, with every option of its help, formatted without a warning.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

const std::string kDocuments = GYROTHERM_SOURCE_DIR "/docs/man/";

/// Returns the source of every page. Fails the test if one is missing.
std::vector<fs::path> page_sources() {
  auto pages = list_folder(kDocuments);
  EXPECT_GE(pages.size(), 29u);
  return pages;
}

/// Returns the commands listed below "Subcommands:" in a help text.
std::vector<std::string> list_commands(const std::string& help) {
  std::vector<std::string> commands;
  std::istringstream lines(help.substr(std::min(help.find("Subcommands:"), help.size())));
  const std::regex command(R"(^  ([a-z-]+) )");
  for (std::string line; std::getline(lines, line);)
    if (std::smatch match; std::regex_search(line, match, command)) commands.push_back(match[1]);
  return commands;
}

/// Returns the text below "# NAME" of a page's prose, up to the next section.
std::string find_section(const std::string& prose, const std::string& name) {
  const auto heading = "# " + name + "\n";
  const auto at = prose.find(heading);
  if (at == std::string::npos) return "";
  const auto begin = at + heading.size();
  return prose.substr(begin, std::min(prose.find("\n# ", begin), prose.size()) - begin);
}

/// Returns the page of a command as the build makes it.
Ran make_page(const std::string& page, const std::string& arguments) {
  return gyrotherm_with("manual " + arguments + " --date 2026-11-21 --prose " + kDocuments + page + ".md");
}

/// Formats a page with man on a terminal of 100 columns.
Ran format_with_man(const std::string& page) {
  const Folder folder;
  return shell("cat > '" + (folder / "page.1") + "'; MANWIDTH=100 LC_ALL=C.UTF-8 man --warnings -E UTF-8 -P cat -l '" +
                   (folder / "page.1") + "' | col -bx",
               page);
}

TEST(Manual, HasPageForEachCommandWithEveryOption) {
  const auto commands = list_commands(gyrotherm_with("--help").out);
  EXPECT_GT(commands.size(), 20u);
  for (const auto& command : commands) {
    EXPECT_TRUE(fs::exists(kDocuments + "gyrotherm-" + command + ".md")) << command;
    if (command == "thermal") continue;  // the page belongs to another program
    const auto page = make_page("gyrotherm-" + command, command);
    ASSERT_EQ(page.exit_code, 0) << page.err;
    const auto plain = std::regex_replace(page.out, std::regex(R"(\\f[BIP])"), " ");
    const auto shown = options_in(std::regex_replace(plain, std::regex(R"(\\-)"), "-"));
    for (const auto& option : options_in(gyrotherm_with(command + " --help").out))
      EXPECT_TRUE(shown.contains(option)) << command << " " << option;
    for (const auto* section : {"NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXAMPLES", "EXIT STATUS", "SEE ALSO"})
      EXPECT_NE(page.out.find(std::string("\n.SH ") + section + "\n"), std::string::npos) << command << section;
  }
}

TEST(Manual, IsBuiltAndPackagedCompletely) {
  const auto built = fs::path(GYROTHERM_PROGRAM).parent_path() / "man";
  const std::string debian = GYROTHERM_SOURCE_DIR "/debian/";
  const auto packaged = read_text_file(debian + "gyrotherm.manpages").value() +
                        read_text_file(debian + "gyrotherm-monitor.manpages").value() +
                        read_text_file(debian + "gyrotherm-site.manpages").value();
  for (const auto& path : page_sources()) {
    const auto page = path.stem().string() + ".1";
    EXPECT_TRUE(fs::exists(built / page)) << page;
    EXPECT_NE(packaged.find("/" + page + "\n"), std::string::npos) << page;
  }
}

TEST(Manual, HasPagesOfOtherProgramsWithEveryOption) {
  const auto folder = fs::path(GYROTHERM_PROGRAM).parent_path().string() + "/";
  std::size_t options = 0;
  for (const auto* program : {"gyrotherm-make-safe", "gyrotherm-monitor", "gyrotherm-pdf"}) {
    const auto help = shell(folder + program + " --help").out;
    const auto prose = read_text_file(kDocuments + program + ".md").value();
    EXPECT_FALSE(help.empty());
    auto wanted = options_in(help);
    if (program == std::string("gyrotherm-monitor"))
      wanted.merge(options_in(shell(folder + "gyrotherm-monitor user add --help").out));
    const auto explained = options_in(find_section(prose, "OPTIONS"));
    EXPECT_EQ(wanted.contains("--help") || program == std::string("gyrotherm-make-safe"), true);
    for (const auto& option : wanted) EXPECT_TRUE(explained.contains(option)) << program << " " << option;
    for (const auto& option : options_in(prose))
      EXPECT_TRUE(wanted.contains(option) || option == "--help") << program << " has no " << option;
    options += wanted.size();
  }
  EXPECT_GT(options, 15u);
}

TEST(Manual, EachProgramPrintsItsVersion) {
  const auto folder = fs::path(GYROTHERM_PROGRAM).parent_path().string() + "/";
  const auto version = gyrotherm_with("--version").out.substr(std::string("gyrotherm").size());
  for (const std::string program : {"make-safe", "monitor", "pdf", "publish", "site", "thermal"})
    EXPECT_EQ(shell(folder + "gyrotherm-" + program + " --version").out, "gyrotherm-" + program + version);
}

TEST(Manual, SynopsesContainOnlyCommandLines) {
  int command_lines = 0;
  for (const auto& path : page_sources()) {
    std::istringstream lines(find_section(read_text_file(path.string()).value(), "SYNOPSIS"));
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(line.empty() || line.starts_with("`gyrotherm")) << path << ": " << line;
      command_lines += line.empty() ? 0 : 1;
    }
  }
  EXPECT_GE(command_lines, 15);
}

TEST(Manual, ExamplesUseExistingOptions) {
  const std::regex example(R"(\n`gyrotherm ([a-z-]+)([^`|]*))");
  int examples = 0, options = 0;
  for (const auto& path : page_sources()) {
    const auto text = read_text_file(path.string()).value();
    for (std::sregex_iterator at(text.begin(), text.end(), example), end; at != end; ++at) {
      const auto known = options_in(gyrotherm_with((*at)[1].str() + " --help").out);
      auto below = known;
      const auto rest = (*at)[2].str();
      if (std::smatch subcommand; std::regex_search(rest, subcommand, std::regex("^ ([a-z]+)(?: |$)")))
        below = options_in(gyrotherm_with((*at)[1].str() + subcommand[0].str() + " --help").out);
      for (const auto& option : options_in((*at)[2])) {
        EXPECT_TRUE(known.contains(option) || below.contains(option)) << path << ": " << at->str();
        ++options;
      }
      ++examples;
    }
  }
  EXPECT_GT(examples, 60);
  EXPECT_GT(options, 80);
}

TEST(Manual, IsFormattedWithoutWarning) {
  if (!installed("man")) GTEST_SKIP() << "man is not installed";
  for (const auto& path : page_sources()) {
    const auto name = path.stem().string();
    const bool is_prose = read_text_file(path.string()).value().starts_with("# NAME");
    const auto command = name == "gyrotherm" ? "" : name.substr(std::string("gyrotherm-").size());
    if (command == "thermal") continue;
    const auto page = make_page(name, is_prose ? "--name " + name : command);
    ASSERT_EQ(page.exit_code, 0) << page.err;
    const auto set = format_with_man(page.out);
    EXPECT_EQ(set.err, "") << name;
    EXPECT_NE(set.out.find("SEE ALSO"), std::string::npos) << name << set.out;
    EXPECT_EQ(set.out.find('`'), std::string::npos) << name << set.out;
  }
}

}  // namespace
}  // namespace gyrotherm::app
