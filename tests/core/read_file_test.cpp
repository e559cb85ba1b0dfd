#include <gtest/gtest.h>

#include <filesystem>

#include "core/text_file.hpp"

namespace gyrotherm {
namespace {

namespace fs = std::filesystem;

TEST(ReadFile, GivesBackWhatWasWritten) {
  const auto path = (fs::path(testing::TempDir()) / "read_file_test.txt").string();
  const std::string text("a\0b\r\n°", 7);
  ASSERT_TRUE(replace_text_file(path, "old, and longer than what replaces it").has_value());
  ASSERT_TRUE(replace_text_file(path, text).has_value());
  EXPECT_EQ(read_text_file(path).value(), text);
  EXPECT_FALSE(fs::exists(path + ".part"));
  fs::remove(path);
}

TEST(ReadFile, NamesTheFileThatIsNotThere) {
  const auto text = read_text_file("/nowhere/at/all.toml");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().kind, FaultKind::bad_file);
  EXPECT_EQ(text.error().where, "/nowhere/at/all.toml");
}

TEST(ReadFile, ADirectoryIsNoFile) { EXPECT_FALSE(read_text_file(testing::TempDir()).has_value()); }

TEST(WriteFile, FailsWhereNothingCanBeWritten) {
  const auto written = replace_text_file("/nowhere/at/all.toml", "x");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().kind, FaultKind::storage);
}

}  // namespace
}  // namespace gyrotherm
