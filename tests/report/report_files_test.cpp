// SPDX-License-Identifier: Apache-2.0
#include "report/report_files.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::report {
namespace {

UsedFile used_file(const char* role, const char* name, const char* content) {
  return {.role = role, .name = name, .sha256 = sha256(content)};
}

bool may_be(const char* name, const char* content, const UsedFile& file, std::vector<UsedFile> others = {}) {
  others.push_back(file);
  return may_be_used_file(
      name, [&] { return sha256(content); }, file, others);
}

TEST(UsedFiles, TextKnownByItsNameIsTomlFileOrHasItsDigest) {
  for (const char* role : {"column_map", "rig", "profile"}) {
    SCOPED_TRACE(role);
    const UsedFile map = used_file(role, "flat2.csv", "name = \"flat2.csv\"");
    EXPECT_FALSE(may_be("flat2.csv", "time,A\n0,20\n", map)) << "the table itself";
    EXPECT_TRUE(may_be("flat2.csv", "name = \"flat2.csv\"", map));
    EXPECT_TRUE(may_be("flat2.csv.toml", "changed", map)) << "a changed map must fail";
  }
  EXPECT_TRUE(may_be("model", "changed", used_file("model_left", "model", "{}")));
  EXPECT_TRUE(may_be("run.db", "changed", used_file("record", "run.db", "rows")));
}

TEST(UsedFiles, FileOfAnotherRoleIsNoCandidate) {
  const UsedFile found = used_file("model_found", "model.json", "old"),
                 left = used_file("model_left", "model.json", "new");
  EXPECT_FALSE(may_be("model.json", "old", left, {found}));
  EXPECT_TRUE(may_be("model.json", "new", left, {found}));
  EXPECT_TRUE(may_be("model.json", "changed", left, {found}));
}

TEST(UsedFiles, TableNamedLikeMapIsNotPartOfReport) {
  tests::TestFolder folder;
  const std::string path = std::filesystem::path(folder / "x").parent_path().string();
  const std::vector<UsedFile> used{used_file("column_map", "flat2.csv", "map")};
  ASSERT_TRUE(replace_text_file(folder / "flat2.csv", "table"));
  EXPECT_EQ(find_unlisted_entries(path, {}, used), std::vector<std::string>{"flat2.csv"});
  ASSERT_TRUE(replace_text_file(folder / "flat2.csv.toml", "map"));
  EXPECT_EQ(find_unlisted_entries(path, {}, used), std::vector<std::string>{"flat2.csv"});
  ASSERT_TRUE(replace_text_file(folder / "flat2.csv", "map"));
  EXPECT_EQ(find_unlisted_entries(path, {}, used), std::vector<std::string>{"flat2.csv.toml"}) << "only one of both";
}

}  // namespace
}  // namespace gyrotherm::report
