// SPDX-License-Identifier: Apache-2.0
/// Table of promises: all named tests exist, and each promise names a test.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

/// Returns "Suite.Name" of every test in the sources, the groups of attacks, and the names of the fuzz targets.
const std::set<std::string>& sources_tests() {
  static const std::set<std::string> all = [] {
    std::set<std::string> found;
    const auto collect = [&](const std::string& text, const char* pattern, const std::string& before) {
      const std::regex one(pattern);
      for (std::sregex_iterator match(text.begin(), text.end(), one), end; match != end; ++match)
        found.insert(before + (*match)[1].str() + (match->size() > 2 ? "." + (*match)[2].str() : ""));
    };
    for (const auto& entry : fs::recursive_directory_iterator(GYROTHERM_SOURCE_DIR "/tests")) {
      const bool cmake = entry.path().filename() == "CMakeLists.txt";
      if (!cmake && entry.path().extension() != ".cpp") continue;
      const auto text = read_text_file(entry.path().string()).value();
      if (!cmake) collect(text, R"(TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\s*\))", "");
      if (cmake) collect(text, R"(gyrotherm_fuzz\((\w+))", "");
      if (cmake) collect(text, R"(gyrotherm_edges\((\w+))", "Edges.");
      if (cmake) collect(text, R"(gyrotherm_monitor_test\((\w+))", "Monitor.");
      if (cmake) collect(text, R"(gyrotherm_site_test\((\w+))", "Site.");
      if (cmake) collect(text, R"(add_test\(NAME (\w+)\.(\w+))", "");
    }
    return found;
  }();
  return all;
}

/// Reads the tables of a page whose rows begin with a letter and a number. Returns the last column of each row by it.
std::map<std::string, std::string> read_rows(const std::string& page) {
  std::istringstream text(read_text_file(GYROTHERM_SOURCE_DIR "/docs/" + page).value());
  const std::regex row(R"(^\| ([PXA]\d+) \| [^|]+ \| (.+) \|$)");
  std::map<std::string, std::string> found;
  std::smatch match;
  for (std::string line; std::getline(text, line);)
    if (std::regex_match(line, match, row)) found[match[1]] = match[2];
  return found;
}

std::map<std::string, std::string> promises() { return read_rows("reliability.md"); }

/// Returns the number of tests that the rows name.
std::size_t expect_named_tests_exist(const std::map<std::string, std::string>& rows) {
  const std::regex name(R"(`((?:[A-Z]\w*\.[A-Z]\w*)|(?:fuzz_\w+))`)");
  std::size_t named = 0;
  for (const auto& [row, held_by] : rows)
    for (std::sregex_iterator match(held_by.begin(), held_by.end(), name), end; match != end; ++match, ++named)
      EXPECT_TRUE(sources_tests().contains((*match)[1])) << row << ": " << (*match)[1];
  return named;
}

TEST(ReliabilityTable, NamesEveryPromise) {
  const auto rows = promises();
  EXPECT_EQ(rows.size(), 28u);
  for (int i = 1; i <= 28; ++i) EXPECT_TRUE(rows.contains("P" + std::to_string(i))) << "P" << i;
}

TEST(ReliabilityTable, NamesExistingTests) { EXPECT_GT(expect_named_tests_exist(promises()), 30u); }

TEST(VerifiedEffects, NamesTestForEachFinding) {
  const auto rows = read_rows("verified-effects.md");
  for (int i = 0; i <= 17; ++i) EXPECT_TRUE(rows.contains("X" + std::to_string(i))) << "X" << i;
  for (int i = 1; i <= 12; ++i) EXPECT_TRUE(rows.contains("A" + std::to_string(i))) << "A" << i;
  EXPECT_GE(expect_named_tests_exist(rows), rows.size());
}

}  // namespace
}  // namespace gyrotherm::app
